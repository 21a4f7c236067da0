"""Any other interface of python-can, as it comes."""

from collections import Counter
from collections.abc import Iterator

import can

from ods.base import clock
from ods.nav_bridge.can.frame import ErrorFrame, Frame
from ods.nav_bridge.can.stamp_clock import StampClock


class PythonCanBus:
    """A bus that python-can reads. Counts `can_ignored`: remote and FD frames."""

    def __init__(self, bus: can.BusABC, stamps: StampClock, counters: Counter[str]) -> None:
        self._bus, self._stamps, self._counters = bus, stamps, counters
        self.send, self.fileno, self.shutdown = bus.send, bus.fileno, bus.shutdown

    def receive(self, limit: int, _woken_ns: int) -> Iterator[Frame | ErrorFrame]:
        """Yield what is waiting, at most `limit` frames, by the driver's stamps. Never waits. Raises CanError."""
        for _ in range(limit):
            message = self._bus.recv(0)
            if message is None:
                return
            t_ns = self._stamps.arrival_ns(round(message.timestamp * clock.NS))
            if message.is_error_frame:
                yield ErrorFrame(message.arbitration_id, bytes(message.data), t_ns)
            elif message.is_remote_frame or message.is_fd:
                self._counters["can_ignored"] += 1
            else:
                yield Frame(message.arbitration_id, message.is_extended_id, bytes(message.data), t_ns)
