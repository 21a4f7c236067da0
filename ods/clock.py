"""The one module that reads the wall clock and maps clocks onto CLOCK_MONOTONIC."""

import time
from collections import deque

NS = 1_000_000_000
DRIFT_DIVISOR = 10_000
"""A device's clock drifts by at most one part in this many: 100 ppm."""
CONFIRMATIONS = 4
"""Consecutive messages that must agree before a jump of a device's clock is believed."""


def monotonic_ns() -> int:
    """Return CLOCK_MONOTONIC, ns: the time base of everything inside one machine."""
    return time.monotonic_ns()


def utc_ns(t_ns: int | None = None) -> int:
    """Return UTC, ns since 1970, of the monotonic instant `t_ns` (now by default), by today's offset of both clocks."""
    return time.time_ns() if t_ns is None else t_ns + utc_offset_ns()


def utc_offset_ns() -> int:
    """Return UTC - CLOCK_MONOTONIC now, ns: the best of three readings, as a thread switch may fall into one."""
    readings = []
    for _ in range(3):
        before, utc, after = time.monotonic_ns(), time.time_ns(), time.monotonic_ns()
        readings.append((after - before, utc - (before + after) // 2))
    return min(readings)[1]


class OffsetEstimator:
    """Maps the clock of one device onto CLOCK_MONOTONIC.

    Delays only add, so the offset is the lower envelope of arrival - device time over the last `window` messages. An
    old minimum is allowed to have grown by 100 ppm of its age, so that a drifting clock is followed. A low value
    counts once two messages in a row stand for it. Messages further than `jump_ns` from the envelope leave it alone
    until CONFIRMATIONS of them in a row tell the same offset: then the device's clock has jumped. Until then such a
    message is taken for a late one, unless its stamp lies before the last one's: messages keep their order on the way,
    so that clock was set back, and the arrival counts.
    """

    def __init__(self, window: int = 64, jump_ns: int = 500_000_000) -> None:
        self.jumps = 0
        """Jumps of the device's clock that were believed."""
        self.wild = 0
        """Messages further than `jump_ns` from the envelope."""
        self._window = window
        self._jump_ns = jump_ns
        self._suspects: deque[tuple[int, int]] = deque(maxlen=CONFIRMATIONS)
        self._envelope: deque[tuple[int, int]] = deque()  # (message number, key), both rising: a sliding minimum
        self._messages = 0
        self._newest_device_ns: int | None = None
        self._previous_key: int | None = None

    def map(self, device_ns: int, arrival_ns: int) -> int:
        """Return the monotonic time of `device_ns`, ns, never later than its message's arrival, and learn from it."""
        if self._is_wild(device_ns, arrival_ns):
            self.wild += 1
            self._suspects.append((device_ns, arrival_ns))
            if not self._jump_confirmed():
                set_back = self._newest_device_ns is not None and device_ns < self._newest_device_ns
                return arrival_ns if set_back else self._mapped(device_ns, arrival_ns)
            self._rebase()
        else:
            self._suspects.clear()
            self._learn(device_ns, arrival_ns)
        self._newest_device_ns = device_ns
        return self._mapped(device_ns, arrival_ns)

    def _mapped(self, device_ns: int, arrival_ns: int) -> int:
        return min(device_ns + self._offset(device_ns, arrival_ns), arrival_ns)

    def _offset(self, device_ns: int, arrival_ns: int) -> int:
        if not self._envelope:
            return arrival_ns - device_ns
        return self._envelope[0][1] + arrival_ns // DRIFT_DIVISOR

    def _is_wild(self, device_ns: int, arrival_ns: int) -> bool:
        return abs(arrival_ns - device_ns - self._offset(device_ns, arrival_ns)) > self._jump_ns

    def _learn(self, device_ns: int, arrival_ns: int) -> None:
        key = arrival_ns - device_ns - arrival_ns // DRIFT_DIVISOR
        previous, self._previous_key = self._previous_key, key
        if previous is None:
            return
        agreed = max(key, previous)
        while self._envelope and self._envelope[-1][1] >= agreed:
            self._envelope.pop()
        self._messages += 1
        self._envelope.append((self._messages, agreed))
        if self._envelope[0][0] <= self._messages - self._window:
            self._envelope.popleft()

    def _jump_confirmed(self) -> bool:
        """Tell whether the suspects came at the pace of the device's clock; a backlog read in one go does not."""
        if len(self._suspects) < CONFIRMATIONS:
            return False
        differences = [arrival - device for device, arrival in self._suspects]
        device_span = abs(self._suspects[-1][0] - self._suspects[0][0])
        return max(differences) - min(differences) <= min(self._jump_ns, device_span // 2)

    def _rebase(self) -> None:
        self.jumps += 1
        self._envelope.clear()
        self._previous_key = None
        for device_ns, arrival_ns in self._suspects:
            self._learn(device_ns, arrival_ns)
        self._suspects.clear()
