"""Links carry a state whole, and nothing that runs."""

import base64
import json
import zlib
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, strategies as st

from ods.pipeline.settings import PipelineSettings
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.paths import PathError, with_value
from ods.workbench.model.share import ShareError, shared_text, state_of
from ods.workbench.model.state import State
from tests.workbench.model.test_history import ACTIONS, START


@given(st.lists(st.sampled_from(ACTIONS), max_size=15))
def test_a_link_gives_the_state_back(actions: list[do.Action]) -> None:
    state = START
    for action in actions:
        try:
            state = apply(state, action)
        except PathError:
            continue
    assert state_of(shared_text(state), START) == state


def _link(tables: object) -> str:
    return base64.urlsafe_b64encode(zlib.compress(json.dumps(tables).encode())).decode()


def test_a_link_names_no_code_and_no_map() -> None:
    foreign = {"pipeline": {"plugins": ["/tmp/evil.py"]}, "tracker": {"plugins": ["evil"], "map": {"path": "/tmp/m"}}}
    chain = {"config": foreign}
    state = state_of(_link({"tuning": chain, "other": chain, "further": [chain, chain]}), State())
    own = State().tuning.config
    for tuning in (state.tuning, state.other, *state.further):
        assert tuning is not None
        assert tuning.config.pipeline.plugins == own.pipeline.plugins
        assert tuning.config.tracker.plugins == own.tracker.plugins
        assert tuning.config.tracker.map == own.tracker.map


def test_the_plug_ins_of_ones_own_configuration_stay() -> None:
    pipeline = PipelineSettings(plugins=(Path("mine.py"),))
    trusted = State(tuning=msgspec.structs.replace(
        START.tuning, config=msgspec.structs.replace(START.tuning.config, pipeline=pipeline)))  # fmt: skip
    assert state_of(shared_text(START), trusted).tuning.config.pipeline.plugins == (Path("mine.py"),)


@pytest.mark.parametrize(
    "text",
    ["", "!", "AAAA", "A" * 100_000, _link([]), _link({"view": {"palette": "mud"}}), _link("x"), _link(None),
     _link({"tuning": 3}), _link({"tuning": {"config": []}}), _link({"tuning": {"config": {"pipeline": 1}}}),
     _link("0" * 5_000_000), "é"],
)  # fmt: skip
def test_what_is_no_state_is_one_line(text: str) -> None:
    with pytest.raises(ShareError, match=r"^link: ") as raised:
        state_of(text, State())
    assert "\n" not in str(raised.value)


@given(st.binary(max_size=200))
def test_whatever_a_link_unpacks_to_does_no_harm(content: bytes) -> None:
    text = base64.urlsafe_b64encode(zlib.compress(content)).decode()
    with pytest.raises(ShareError):
        state_of(text, State())


def test_a_value_that_is_no_path_names_the_key() -> None:
    with pytest.raises(PathError, match="plugins"):
        with_value(State().tuning.config, "pipeline.plugins", 3)
