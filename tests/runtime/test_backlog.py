"""What waits is worked off as a whole while that keeps up, else only the newest; made-up times."""

from ods.runtime.backlog import Backlog

MS = 1_000_000


def backlog(work_ms: float, interval_ms: int) -> Backlog[int]:
    """Return one that knows its pace."""
    made: Backlog[int] = Backlog()
    for number in range(3):
        made.add(number, number, number * interval_ms * MS)
    made.take()
    made.worked(round(work_ms * MS))
    return made


def test_a_burst_is_worked_off_in_order_if_that_takes_no_longer_than_until_the_next_message() -> None:
    made = backlog(work_ms=40.0, interval_ms=100)
    for number in (3, 4):
        made.add(number, number, number * 100 * MS)
    assert made.take() == ([3, 4], 0)
    for number in (5, 6, 7):
        made.add(number, number, number * 100 * MS)
    assert made.take() == ([7], 2)
    assert made.take() == ([], 0)


def test_slow_work_gets_the_newest_and_before_the_first_nobody_knows() -> None:
    made = backlog(work_ms=300.0, interval_ms=100)
    for number in (3, 4):
        made.add(number, number, number * 100 * MS)
    assert made.take() == ([4], 1)
    assert made.slowness() == "a ping takes 300.0 ms to process, they come every 100.0 ms"
    unknown: Backlog[int] = Backlog()
    for number in range(5):
        unknown.add(number, number, number)
    assert unknown.take() == ([4], 4)
    assert unknown.slowness() == "pings came while it started"


def test_messages_that_were_lost_and_a_sender_that_starts_afresh_do_not_spoil_the_interval() -> None:
    made: Backlog[int] = Backlog()
    for seq, at_ms in ((0, 0), (10, 1000), (0, 1050), (1, 1150), (1, 1150)):
        made.add(seq, seq, at_ms * MS)
    assert made.interval_ns == 100 * MS
