"""Work in a process of its own: its result, its errors and how far it is come here; it can be given up."""

import os

import pytest

from ods.base.errors import OdsError
from ods.workbench.engine.background.own_process import GoesOn, in_own_process, whole


def keeping(shares: list[float], most: int = 1_000_000) -> GoesOn:
    """Return what keeps the shares that are told, and gives up after so many."""

    def tell(share: float) -> bool:
        shares.append(share)
        return len(shares) < most

    return tell


def steps(tell: GoesOn, count: int) -> tuple[int, int]:
    """Return where it ran, and how many steps were done."""
    for done in range(1, count + 1):
        if not tell(done / count):
            return os.getpid(), done
    return os.getpid(), count


def fails(_: GoesOn, error: Exception) -> None:
    raise error


def dies(_: GoesOn) -> None:
    os._exit(3)


def test_it_runs_elsewhere_tells_how_far_it_is_and_can_be_given_up() -> None:
    shares: list[float] = []
    process, done = in_own_process(steps, keeping(shares, most=3), 10)
    assert process != os.getpid()
    assert done == 3
    assert shares == pytest.approx([0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("error", "why"), [(OdsError("a.npz: no pings"), "^a.npz: no pings$"), (ValueError("bad"), "^ValueError: bad$")]
)
def test_its_errors_are_told_here(error: Exception, why: str) -> None:
    with pytest.raises(OdsError, match=why):
        in_own_process(fails, whole, error)


def test_one_that_is_killed_is_told() -> None:
    with pytest.raises(OdsError, match="ended before its time"):
        in_own_process(dies, whole)
