"""The network's UTC, as TIME messages tell it."""

import struct
from collections import Counter

from ods.base.clock import NS
from ods.base.clock_sync import OffsetEstimator
from ods.nav_bridge.can.frame import Frame
from ods.nav_bridge.ins_clock import day_ms, utc_of_time_of_day

TIME_FRAME = struct.Struct("<IH")
LATE_NS = NS // 2
WINDOW = 16
"""TIME messages that the offset is taken from."""


class NetworkTime:
    """What TIME says of UTC; poses do not depend on it.

    Counts `time`, `time_bad`, `time_wild` (late, or otherwise off by more than half a second) and `time_jumps` (four
    such in a row that agree).
    """

    def __init__(self, counters: Counter[str]) -> None:
        self._counters = counters
        self._offset = OffsetEstimator(WINDOW, LATE_NS)
        self._told: tuple[int, int] | None = None

    def take(self, frame: Frame) -> None:
        """Take a TIME message."""
        raw, days = TIME_FRAME.unpack(frame.data) if len(frame.data) == TIME_FRAME.size else (-1, 0)
        milliseconds = day_ms(raw) if raw >= 0 else None
        if milliseconds is None:
            self._counters["time_bad"] += 1
            return
        utc, wild, jumps = utc_of_time_of_day(milliseconds, days), self._offset.wild, self._offset.jumps
        t_ns = self._offset.map(utc, frame.t_ns)
        if self._offset.wild == wild or self._offset.jumps > jumps:  # one message off is a late one, not a new time
            self._told = t_ns, utc
        self._counters["time"] += 1
        self._counters["time_wild"], self._counters["time_jumps"] = self._offset.wild, self._offset.jumps

    @property
    def ahead_ns(self) -> int | None:
        """How far the network's UTC is ahead of CLOCK_MONOTONIC; None: nobody has told."""
        return None if self._told is None else self._told[1] - self._told[0]
