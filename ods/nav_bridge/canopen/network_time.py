"""The network's UTC, as TIME messages tell it."""

import struct
from collections import Counter

from ods.nav_bridge.can.frame import Frame
from ods.nav_bridge.clocks.ins_clock import day_ms, utc_of_time_of_day
from ods.nav_bridge.clocks.told_utc import ToldUtc

TIME_FRAME = struct.Struct("<IH")


class NetworkTime(ToldUtc):
    """Counts `time_bad` (malformed, too), and what `ToldUtc` does."""

    def __init__(self, counters: Counter[str]) -> None:
        super().__init__(counters)
        self._counters = counters

    def take_frame(self, frame: Frame) -> None:
        """Take a TIME message."""
        raw, days = TIME_FRAME.unpack(frame.data) if len(frame.data) == TIME_FRAME.size else (-1, 0)
        milliseconds = day_ms(raw) if raw >= 0 else None
        if milliseconds is None:
            self._counters["time_bad"] += 1
            return
        self.take(utc_of_time_of_day(milliseconds, days), frame.t_ns)
