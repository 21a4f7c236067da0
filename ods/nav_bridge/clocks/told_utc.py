"""UTC as a navigation system or its network tells it."""

from collections import Counter

from ods.base.clock import NS
from ods.base.clock_sync import OffsetEstimator

LATE_NS = NS // 2
EARLIEST_NS, LATEST_NS = 1_577_836_800 * NS, 4_102_444_800 * NS
"""From 2020 until 2100: before lie GPS weeks that went round, clocks without a fix, and years of two digits; no message
carries what is beyond 2116."""
WINDOW = 16
"""Messages that the offset is taken from."""


class ToldUtc:
    """Poses are stamped with it where this computer's clock is the worse one; their instants do not depend on it.

    Counts `time`, `time_bad` (of a year that cannot be), `time_wild` (late, or else off by more than half a second)
    and `time_jumps` (four such in a row that agree).
    """

    def __init__(self, counters: Counter[str]) -> None:
        self._counters = counters
        self._offset = OffsetEstimator(WINDOW, LATE_NS)
        self._told: tuple[int, int] | None = None

    def take(self, utc_ns: int, arrival_ns: int) -> None:
        """Take UTC, ns since 1970, told by a message of `arrival_ns`."""
        if not EARLIEST_NS <= utc_ns < LATEST_NS:
            self._counters["time_bad"] += 1
            return
        wild, jumps = self._offset.wild, self._offset.jumps
        t_ns = self._offset.map(utc_ns, arrival_ns)
        if self._offset.wild == wild or self._offset.jumps > jumps:  # one message off is a late one, not a new time
            self._told = t_ns, utc_ns
        self._counters["time"] += 1
        self._counters["time_wild"], self._counters["time_jumps"] = self._offset.wild, self._offset.jumps

    @property
    def ahead_ns(self) -> int | None:
        """How far the told UTC is ahead of CLOCK_MONOTONIC; None: nobody has told."""
        return None if self._told is None else self._told[1] - self._told[0]
