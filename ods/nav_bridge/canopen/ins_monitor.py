"""State of the INS: heartbeat with a time-out of our own, emergencies and SYNC."""

from collections import Counter, deque

from canopen.emcy import EmcyError

from ods.base.clock import NS
from ods.nav_bridge.can.frame import EMCY_FRAME, Frame
from ods.nav_bridge.canopen.recent import DuplicateNode

BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
STATES = {BOOT_UP: "starting", STOPPED: "stopped", OPERATIONAL: "operational", PRE_OPERATIONAL: "pre-operational"}
TOGGLE_BIT = 0x80
MAX_ERRORS = 8
"""Newest active errors kept; an INS in trouble may send them for ever."""
ALTERNATING = 4
"""Heartbeats whose states alternate: more than one node is behind them."""


class InsMonitor:
    """Follows the INS by everything but its PDOs.

    Counts `heartbeat_bad`, `emcy`, `emcy_bad`, `sync`, `ins_boot_up`, and `ins_twice` for heartbeats that show two
    states in turn.
    """

    def __init__(self, heartbeat_timeout_s: float, now_ns: int, counters: Counter[str]) -> None:
        self.state: int | None = None
        """NMT state in the newest heartbeat."""
        self.sync_ns: int | None = None
        """Arrival of the newest SYNC."""
        self.duplicate = DuplicateNode("ins_twice", counters, 1)
        self.timeout_ns = round(heartbeat_timeout_s * NS)
        """Silence of the heartbeat that is a problem; 0: none is."""
        self._heartbeat_ns = now_ns
        self._counters = counters
        self._states: deque[int] = deque(maxlen=ALTERNATING)
        self._errors: dict[int, str] = {}

    def heartbeat(self, frame: Frame) -> None:
        """Take a heartbeat or boot-up message."""
        state = frame.data[0] & ~TOGGLE_BIT if len(frame.data) == 1 else None
        if state not in STATES:
            self._counters["heartbeat_bad"] += 1
            return
        if state == BOOT_UP:
            self._counters["ins_boot_up"] += 1
            self._errors.clear()
            self._states.clear()
        else:
            self._states.append(state)
        self.state = state
        self._heartbeat_ns = frame.t_ns
        states = list(self._states)
        if len(states) == ALTERNATING and states[0] != states[1] and states[:2] == states[2:]:
            self.duplicate.seen(frame.t_ns)

    def received_epoch(self) -> None:
        """Record PDOs: an INS that sends them is operational, even if it has no heartbeat to say so."""
        if self.state == BOOT_UP:
            self.state = OPERATIONAL

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

    def silent_ns(self, now_ns: int) -> int:
        """Return for how long the heartbeat has been lost, 0 while it is not."""
        silent_ns = now_ns - self._heartbeat_ns
        return silent_ns if self.timeout_ns and silent_ns > self.timeout_ns else 0

    def problems(self, now_ns: int) -> list[str]:
        """Return the problems of the INS, a text each."""
        found = list(self._errors.values())
        silent_ns = self.silent_ns(now_ns)
        if silent_ns:
            found.append(
                f"INS heartbeat lost for {silent_ns / NS:.1f} s" if self.state is not None else "no INS heartbeat"
            )
        elif self.state not in (None, OPERATIONAL):
            found.append(f"INS is {STATES[self.state]}")
        return found
