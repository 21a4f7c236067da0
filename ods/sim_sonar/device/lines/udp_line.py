"""The far end of datagrams: answers whoever sent the last one, as a bridge between a network and a serial line does."""

import contextlib
import socket

from ods.sim_sonar.device.lines.tcp_line import HOST, READ_BYTES

LARGEST = 1024
"""Bytes of a datagram that is sent: a bridge sends what it has read of the line, whole messages or not."""
MAX_READS = 16


class UdpLine:
    """One port, one peer at a time. Data are sent only after a request."""

    needs_subscription = False

    def __init__(self, port: int) -> None:
        """`port` 0: any that is free, see `port`."""
        self.port = port
        self.lost_bytes = 0
        self.connections = 0
        self._socket: socket.socket | None = None
        self._peer: tuple[str, int] | None = None
        self.plug()

    def plug(self) -> None:
        """Listen."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK)
        self._socket.bind((HOST, self.port))
        self.port = self._socket.getsockname()[1]

    def unplug(self) -> None:
        """Stop to listen, forget the peer."""
        if self._socket is not None:
            self._socket.close()
        self._socket = self._peer = None

    def write(self, records: list[bytes], _patience_s: float) -> bool:
        """Send records in datagrams; count what cannot be sent."""
        sent = self._socket is not None and self._peer is not None
        for record in records:
            for begin in range(0, len(record), LARGEST):
                sent = self._sent(record[begin : begin + LARGEST]) and sent
        return sent

    def read(self) -> bytes:
        """Return received bytes, b'' if none."""
        data = b""
        for _ in range(MAX_READS):
            if self._socket is None:
                break
            try:
                more, peer = self._socket.recvfrom(READ_BYTES)
            except OSError:
                break
            self.connections += peer != self._peer
            self._peer = peer
            data += more
        return data

    def _sent(self, data: bytes) -> bool:
        if self._socket is not None and self._peer is not None:
            with contextlib.suppress(OSError):
                return self._socket.sendto(data, self._peer) == len(data)
        self.lost_bytes += len(data)
        return False
