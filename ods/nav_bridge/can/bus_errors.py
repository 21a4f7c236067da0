"""The state of the CAN controller, as reported by error frames (Linux, can/error.h)."""

from collections import Counter
from collections.abc import Iterator

from ods.nav_bridge.can.frame import ErrorFrame

CONTROLLER, NO_ACKNOWLEDGEMENT, BUS_OFF, RESTARTED = 0x004, 0x020, 0x040, 0x100
"""Bits of `ErrorFrame.classes`."""
ERROR_WARNING, ERROR_PASSIVE, ERROR_ACTIVE = 0x0C, 0x30, 0x40
"""Bits of the second data byte, with CONTROLLER: error counters above 96, above 127, below again."""
RECENT_NS = 1_500_000_000
"""Time after the last sign for which missing acknowledgement is reported, s."""


class BusErrors:
    """Follows one controller. Counts `can_error_frames`, `can_bus_off`, and `can_recovered`: ends of bus-off."""

    def __init__(self, counters: Counter[str]) -> None:
        self._counters = counters
        self._off = self._passive = False
        self._lonely_ns: int | None = None

    def take(self, frame: ErrorFrame) -> None:
        """Take an error frame."""
        self._counters["can_error_frames"] += 1
        state = frame.data[1] if frame.classes & CONTROLLER and len(frame.data) > 1 else 0
        if state & (ERROR_WARNING | ERROR_PASSIVE | ERROR_ACTIVE):
            self._passive = bool(state & ERROR_PASSIVE)
        if frame.classes & NO_ACKNOWLEDGEMENT:
            self._lonely_ns = frame.t_ns
        if frame.classes & BUS_OFF:
            self._counters["can_bus_off"] += not self._off
            self._off = True
        if frame.classes & RESTARTED:
            self.works()
            self._passive = False

    def works(self) -> None:
        """Take note of a frame off the bus, which ends bus-off; a controller then restarts."""
        if self._off:
            self._counters["can_recovered"] += 1
            self._off = self._passive = False

    def lost(self) -> None:
        """Take note that the interface was lost: that the controller is well again may be missed."""
        self._passive = False

    def problems(self, now_ns: int) -> Iterator[str]:
        """Return the problems, a text each."""
        if self._off:
            yield "bus-off: wiring, termination or bit rate"
        elif self._passive:
            yield "many errors on the bus (error-passive): wiring, termination or bit rate"
        if self._lonely_ns is not None and now_ns - self._lonely_ns < RECENT_NS:
            yield "no node acknowledges: there is no other node on the bus, or it has another bit rate"
