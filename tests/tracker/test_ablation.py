"""The ablation switches off what is there: a mechanism that was renamed would end the command after its first run."""

import pytest

from benchmarks.ablation import MECHANISMS, Variant
from ods.tracker.existence.model import MODEL


@pytest.mark.parametrize("name", MECHANISMS)
def test_each_mechanism_can_be_switched_off_and_on_again(name: str) -> None:
    before = MODEL.copy()

    for switch in MECHANISMS[name].switches:
        with switch():
            pass

    assert (before == MODEL).all()
    assert Variant(name, (name,)).settings()
