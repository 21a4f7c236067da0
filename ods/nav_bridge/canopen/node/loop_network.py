"""canopen's network without its threads: its owner's loop sends, receives and keeps time."""

from typing import Any

import canopen

from ods.base.clock import NS
from ods.nav_bridge.source import Send


class _PeriodicFrame:
    """A frame that `LoopNetwork.tick` sends again and again; the interface is that of canopen's own task."""

    def __init__(self, can_id: int, data: bytes, period_s: float) -> None:
        self.can_id, self.data = can_id, data
        self.period_ns = round(period_s * NS)
        self.due_ns = 0
        self.stopped = False

    def update(self, data: bytes) -> None:
        self.data = bytes(data)

    def stop(self) -> None:
        self.stopped = True


class LoopNetwork(canopen.Network):
    """Frames leave through `send`, periodic ones when `tick` finds them due."""

    def __init__(self, send: Send) -> None:
        super().__init__()
        self._send = send
        self._periodic: list[_PeriodicFrame] = []

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        """Send a frame, as canopen asks for it."""
        self._send(can_id, bytes(data))

    def send_periodic(self, can_id: int, data: bytes, period: float, remote: bool = False) -> Any:
        """Return a task that sends a frame every `period` s."""
        frame = _PeriodicFrame(can_id, bytes(data), period)
        self._periodic.append(frame)
        return frame

    def tick(self, now_ns: int) -> None:
        """Send what is due."""
        self._periodic = [frame for frame in self._periodic if not frame.stopped]
        for frame in self._periodic:
            if now_ns >= frame.due_ns:
                frame.due_ns = now_ns + frame.period_ns
                self._send(frame.can_id, frame.data)
