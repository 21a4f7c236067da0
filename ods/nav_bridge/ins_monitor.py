"""How the INS is: heartbeat with a time-out of our own, emergencies, SYNC and TIME."""

import struct
from collections import Counter

from canopen.emcy import EmcyError

from ods.clock import NS
from ods.nav_bridge.can_frame import Frame
from ods.nav_bridge.ins_clock import day_ms, utc_ns

BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
STATES = {BOOT_UP: "starting", STOPPED: "stopped", OPERATIONAL: "operational", PRE_OPERATIONAL: "pre-operational"}
TOGGLE_BIT = 0x80
EMCY_FRAME = struct.Struct("<HB5x")
TIME_FRAME = struct.Struct("<IH")
MAX_ERRORS = 8
"""Newest active errors kept; an INS in trouble may send them for ever."""
CLOCK_TOLERANCE_NS = NS


class InsMonitor:
    """Follows the INS by everything but its PDOs.

    Counts `heartbeat_bad`, `emcy`, `emcy_bad`, `sync`, `time`, `time_bad`, `ins_boot_up`.
    """

    def __init__(self, heartbeat_timeout_s: float, now_ns: int, counters: Counter[str]) -> None:
        self.state: int | None = None
        """NMT state that the newest heartbeat told."""
        self.sync_ns: int | None = None
        """Arrival of the newest SYNC."""
        self._timeout_ns = round(heartbeat_timeout_s * NS)
        self._heartbeat_ns = now_ns
        self._counters = counters
        self._errors: dict[int, str] = {}
        self._utc: tuple[int, int] | None = None

    def heartbeat(self, frame: Frame) -> None:
        """Take a heartbeat or boot-up message."""
        state = frame.data[0] & ~TOGGLE_BIT if len(frame.data) == 1 else None
        if state not in STATES:
            self._counters["heartbeat_bad"] += 1
            return
        if state == BOOT_UP:
            self._counters["ins_boot_up"] += 1
            self._errors.clear()
        self.state = state
        self._heartbeat_ns = frame.t_ns

    def emergency(self, frame: Frame) -> None:
        """Take an EMCY message; error code 0x00xx resets."""
        if len(frame.data) != EMCY_FRAME.size:
            self._counters["emcy_bad"] += 1
            return
        self._counters["emcy"] += 1
        code, register = EMCY_FRAME.unpack(frame.data)
        if code & 0xFF00 == 0:
            self._errors.clear()
            return
        self._errors.pop(code, None)
        kind = EmcyError(code, register, b"", 0.0).get_desc().lower() or "unknown kind"
        self._errors[code] = f"INS error 0x{code:04X} ({kind}), error register 0x{register:02X}"
        while len(self._errors) > MAX_ERRORS:
            del self._errors[next(iter(self._errors))]

    def sync(self, frame: Frame) -> None:
        """Take a SYNC."""
        self._counters["sync"] += 1
        self.sync_ns = frame.t_ns

    def time(self, frame: Frame) -> None:
        """Take a TIME message: the network's UTC."""
        raw, days = TIME_FRAME.unpack(frame.data) if len(frame.data) == TIME_FRAME.size else (-1, 0)
        milliseconds = day_ms(raw) if raw >= 0 else None
        if milliseconds is None:
            self._counters["time_bad"] += 1
            return
        self._counters["time"] += 1
        self._utc = (frame.t_ns, utc_ns(milliseconds, days))

    def problems(self, now_ns: int, now_utc_ns: int) -> list[str]:
        """Say in plain words what is wrong with the INS."""
        found = list(self._errors.values())
        silent_ns = now_ns - self._heartbeat_ns
        if self._timeout_ns and silent_ns > self._timeout_ns:
            found.append(
                f"INS heartbeat lost for {silent_ns / NS:.1f} s" if self.state is not None else "no INS heartbeat"
            )
        elif self.state not in (None, OPERATIONAL):
            found.append(f"INS is {STATES[self.state]}")
        if self._utc is not None:
            heard_ns, utc = self._utc
            ahead_ns = utc - (now_utc_ns - now_ns + heard_ns)
            if abs(ahead_ns) > CLOCK_TOLERANCE_NS:
                found.append(f"UTC of the INS is {ahead_ns / NS:+.1f} s from this machine's")
        return found
