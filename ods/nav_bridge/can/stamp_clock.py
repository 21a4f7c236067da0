"""The wall clock, by which drivers stamp frames, and CLOCK_MONOTONIC, by which everything else goes on."""

from collections import Counter

from ods.base import clock

WALL_CLOCK_STEP_NS = 100_000_000
"""NTP slews by less than this between two looks; a step is larger."""
SLACK_NS = 50_000_000
"""Longest delay of a frame from the driver, ns."""


class StampClock:
    """Maps stamps onto CLOCK_MONOTONIC. Counts `wall_clock_steps`.

    A frame that is read has come since the driver's queue was last empty. That says whether it was stamped before or
    after a step of the wall clock, however long it has waited since.
    """

    def __init__(self, counters: Counter[str]) -> None:
        self._counters = counters
        self._ahead_ns, self._empty_ns = _both_clocks()

    def emptied(self) -> None:
        """Take note that no frame is waiting now."""
        ahead_ns, self._empty_ns = _both_clocks()
        self._counters["wall_clock_steps"] += abs(ahead_ns - self._ahead_ns) > WALL_CLOCK_STEP_NS
        self._ahead_ns = ahead_ns

    def arrival_ns(self, stamp_utc_ns: int) -> int:
        """Return the monotonic time of a frame just read; now, if its stamp is not of the wall clock."""
        ahead_ns, now_ns = _both_clocks()
        for arrival_ns in (stamp_utc_ns - ahead_ns, stamp_utc_ns - self._ahead_ns):
            if self._empty_ns - SLACK_NS <= arrival_ns <= now_ns:
                return arrival_ns
        return now_ns


def _both_clocks() -> tuple[int, int]:
    """Return how far UTC is ahead, ns, and now on CLOCK_MONOTONIC."""
    utc_ns, now_ns = clock.utc_ns(), clock.monotonic_ns()  # so that a pause between makes arrivals later, not earlier
    return utc_ns - now_ns, now_ns
