"""Work in a process of its own: its result, errors and progress come here; it can be given up."""

import os
import time
from functools import partial

import pytest

from ods.base.errors import OdsError
from ods.workbench.engine.background import own_process
from ods.workbench.engine.background.own_process import GoesOn, OwnProcess, in_own_process, whole


def keeping(shares: list[float], most: int = 1_000_000) -> GoesOn:
    """Return what keeps the shares that are reported, and gives up after so many."""

    def report(share: float) -> bool:
        shares.append(share)
        return len(shares) < most

    return report


def steps(report: GoesOn, count: int) -> tuple[int, int]:
    """Return where it ran, and how many steps were done."""
    for done in range(1, count + 1):
        if not report(done / count):
            return os.getpid(), done
    return os.getpid(), count


class Counting:
    def __init__(self, count: int) -> None:
        self.count = count

    def __call__(self, report: GoesOn, more: int) -> tuple[int, int]:
        self.count += more
        report(1.0)
        return os.getpid(), self.count


def now_is(niceness: int) -> None:
    own_process.NICER = niceness


def niceness(_: GoesOn) -> int:
    return own_process.NICER


def fails(_: GoesOn, error: Exception) -> None:
    raise error


def dies(_: GoesOn) -> None:
    os._exit(3)


def hangs_once(_: GoesOn, hangs: bool) -> int:
    if hangs:
        time.sleep(3600.0)
    return os.getpid()


def test_it_runs_elsewhere_reports_progress_and_can_be_given_up() -> None:
    shares: list[float] = []
    process, done = in_own_process(steps, keeping(shares, most=3), 10)
    assert process != os.getpid()
    assert done == 3
    assert shares == pytest.approx([0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("error", "why"), [(OdsError("a.npz: no pings"), "^a.npz: no pings$"), (ValueError("bad"), "^ValueError: bad$")]
)
def test_its_errors_are_raised_here(error: Exception, why: str) -> None:
    with pytest.raises(OdsError, match=why):
        in_own_process(fails, whole, error)


def test_one_that_lives_keeps_what_it_has_until_it_is_ended_and_then_begins_anew() -> None:
    process = OwnProcess(Counting(10))
    (first, one), (again, two) = process(whole, 1), process(whole, 5)
    assert (one, two) == (11, 16)
    assert first == again != os.getpid()
    process.end()
    other, three = process(whole, 1)
    assert three == 11
    assert other not in (first, os.getpid())
    process.end()


def test_an_error_does_not_end_it_but_one_of_the_caller_does() -> None:
    process = OwnProcess(Counting(0))
    process(whole, 3)
    with pytest.raises(OdsError, match="TypeError"):
        process(whole, "x")  # type: ignore[arg-type]
    assert process(whole, 4)[1] == 7

    def interrupts(_: float) -> bool:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        process(interrupts, 1)
    assert process(whole, 1)[1] == 1
    process.end()


def test_what_the_page_began_with_is_done_there_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own_process, "at_first", [partial(now_is, 7)])
    assert in_own_process(niceness, whole) == 7


def test_one_that_is_killed_is_reported() -> None:
    with pytest.raises(OdsError, match="process ended unexpectedly"):
        in_own_process(dies, whole)


def test_one_that_hangs_is_killed_and_the_next_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    process = OwnProcess(hangs_once)
    first = process(whole, False)
    monkeypatch.setattr(own_process, "SILENT_S", 0.2)
    monkeypatch.setattr(own_process, "ENDING_S", 0.2)
    with pytest.raises(OdsError, match="hangs: no progress in 0 s"):
        process(whole, True)
    with pytest.raises(ProcessLookupError):
        os.kill(first, 0)
    monkeypatch.undo()
    assert process(whole, False) != first
    process.end()
