"""python-can's socketcan bus with a reader of its own: one system call a frame, the kernel's time stamps in full."""

import socket
import struct
from collections import Counter
from collections.abc import Iterator
from typing import Any

from can.interfaces.socketcan import SocketcanBus as PythonCanBus

from ods import clock
from ods.nav_bridge.can_frame import ErrorFrame, Frame
from ods.nav_bridge.wall_clock import WallClock

CAN_FRAME = struct.Struct("=IB3x8s")
CAN_FD_BYTES = 72
EXTENDED, REMOTE, ERROR = 1 << 31, 1 << 30, 1 << 29
STANDARD_MASK, EXTENDED_MASK = 0x7FF, 0x1FFFFFFF
TIMESPEC = struct.Struct("@ll")
ANCILLARY_BYTES = socket.CMSG_SPACE(TIMESPEC.size)
SO_RCVBUFFORCE = 33


class SocketcanBus(PythonCanBus):
    """A SocketCAN interface. Counts `can_ignored`: remote and FD frames."""

    def __init__(
        self, channel: str, wall_clock: WallClock, counters: Counter[str], buffer_bytes: int, **options: Any
    ) -> None:
        """`buffer_bytes`: size of the kernel's receive buffer."""
        self._wall_clock, self._counters = wall_clock, counters
        super().__init__(channel, **options)
        _enlarge(self.socket, buffer_bytes)

    def receive(self, limit: int, _woken_ns: int) -> Iterator[Frame | ErrorFrame]:
        """Yield what is waiting, at most `limit` frames, by the kernel's stamps. Never waits. Raises OSError."""
        for _ in range(limit):
            try:
                raw, ancillary, _, _ = self.socket.recvmsg(CAN_FD_BYTES, ANCILLARY_BYTES, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return
            can_id, length, data = CAN_FRAME.unpack_from(raw)
            if can_id & ERROR:
                yield ErrorFrame(can_id & EXTENDED_MASK, data, self._arrival_ns(ancillary))
            elif can_id & REMOTE or len(raw) > CAN_FRAME.size:
                self._counters["can_ignored"] += 1
            else:
                extended = bool(can_id & EXTENDED)
                number = can_id & (EXTENDED_MASK if extended else STANDARD_MASK)
                yield Frame(number, extended, data[:length], self._arrival_ns(ancillary))

    def _arrival_ns(self, ancillary: list[tuple[int, int, bytes]]) -> int:
        for _, _, stamp in ancillary:  # python-can has asked for SO_TIMESTAMPNS alone
            seconds, nanoseconds = TIMESPEC.unpack(stamp)
            return self._wall_clock.arrival_ns(seconds * clock.NS + nanoseconds)
        return clock.monotonic_ns()


def _enlarge(sock: socket.socket, size: int) -> None:
    """Set the receive buffer, beyond the system's limit where the process may."""
    try:
        sock.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, size)
    except OSError:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, size)
