"""python-can's socketcan bus with a reader of its own: one system call a frame, the kernel's time stamps in full."""

import socket
import struct
from collections import Counter
from collections.abc import Iterator
from typing import Any

from can.interfaces.socketcan import SocketcanBus as PythonSocketcanBus

from ods.base import clock
from ods.nav_bridge.can.frame import EXTENDED_MASK, STANDARD_MASK, ErrorFrame, Frame
from ods.nav_bridge.can.stamp_clock import StampClock

CAN_FRAME = struct.Struct("=IB3x8s")
CAN_FD_BYTES = 72
EXTENDED_FLAG, REMOTE_FLAG, ERROR_FLAG = 1 << 31, 1 << 30, 1 << 29
TIMESPEC = struct.Struct("@ll")
DROPPED = struct.Struct("@I")
ANCILLARY_BYTES = socket.CMSG_SPACE(TIMESPEC.size) + socket.CMSG_SPACE(DROPPED.size)
SO_RCVBUFFORCE, SO_RXQ_OVFL = 33, 40


class SocketcanBus(PythonSocketcanBus):
    """A SocketCAN interface. Counts `can_ignored` (remote, FD) and `can_overflow` (lost in a full receive buffer)."""

    def __init__(
        self, channel: str, stamps: StampClock, counters: Counter[str], buffer_bytes: int, **options: Any
    ) -> None:
        """`buffer_bytes`: size of the kernel's receive buffer."""
        self._stamps, self._counters = stamps, counters
        super().__init__(channel, **options)
        self._dropped = 0
        self.socket.setsockopt(socket.SOL_SOCKET, SO_RXQ_OVFL, 1)
        _enlarge(self.socket, buffer_bytes)

    def receive(self, limit: int, _woken_ns: int) -> Iterator[Frame | ErrorFrame]:
        """Yield what is waiting, at most `limit` frames, by the kernel's stamps. Never waits. Raises OSError."""
        for _ in range(limit):
            try:
                raw, ancillary, _, _ = self.socket.recvmsg(CAN_FD_BYTES, ANCILLARY_BYTES, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return
            can_id, length, data = CAN_FRAME.unpack_from(raw)
            if can_id & ERROR_FLAG:
                yield ErrorFrame(can_id & EXTENDED_MASK, data, self._arrival_ns(ancillary))
            elif can_id & REMOTE_FLAG or len(raw) > CAN_FRAME.size:
                self._counters["can_ignored"] += 1
            else:
                extended = bool(can_id & EXTENDED_FLAG)
                number = can_id & (EXTENDED_MASK if extended else STANDARD_MASK)
                yield Frame(number, extended, data[:length], self._arrival_ns(ancillary))

    def _arrival_ns(self, ancillary: list[tuple[int, int, bytes]]) -> int:
        arrival_ns = None
        for _, kind, data in ancillary:
            if kind == SO_RXQ_OVFL:
                (dropped,) = DROPPED.unpack(data)
                self._counters["can_overflow"] += (dropped - self._dropped) % (1 << 32)
                self._dropped = dropped
            else:  # SO_TIMESTAMPNS, for which python-can has asked
                seconds, nanoseconds = TIMESPEC.unpack(data)
                arrival_ns = self._stamps.arrival_ns(seconds * clock.NS + nanoseconds)
        return clock.monotonic_ns() if arrival_ns is None else arrival_ns


def _enlarge(sock: socket.socket, size: int) -> None:
    """Set the receive buffer, beyond the system's limit where the process may."""
    try:
        sock.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, size)
    except OSError:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, size)
