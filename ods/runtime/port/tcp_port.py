"""A TCP connection to the sonar, as a port: connecting never blocks, and silence ends a half-open connection."""

import ipaddress
import select
import socket
from collections import Counter

from ods.base.clock import NS
from ods.runtime.port.address import TcpAddress
from ods.runtime.port.port import PORT_READ_BYTES, PortError
from ods.runtime.port.socket_port import SocketPort

CONNECT_S = 5.0
"""A connection that takes longer is given up."""


class TcpPort(SocketPort):
    """One connection, made again when it is lost or silent for `silence_s` (0: it may be silent for ever)."""

    def __init__(
        self,
        address: TcpAddress,
        silence_s: float,
        pauses_s: tuple[float, float],
        counters: "Counter[str] | None" = None,
    ) -> None:
        """Make a closed port; pauses_s: shortest and longest pause before it is tried again."""
        super().__init__(f"{address.host} port {address.port}", pauses_s, counters)
        self._address = address.host, address.port
        self._family = socket.AF_INET6 if ipaddress.ip_address(address.host).version == 6 else socket.AF_INET
        self._silence_s = silence_s
        self._begun_ns = 0

    def _begin_opening(self, now_ns: int) -> None:
        self._socket = socket.socket(self._family, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._begun_ns = now_ns
        self._socket.connect_ex(self._address)  # how it went is read from the socket

    def _finish_opening(self, now_ns: int) -> bool:
        connection = self._connection()
        poll = select.poll()
        poll.register(connection, select.POLLOUT)
        if not poll.poll(0):
            if now_ns - self._begun_ns > CONNECT_S * NS:
                raise PortError(f"no answer within {CONNECT_S:g} s")
            return False
        self._raise_error()
        connection.getpeername()  # raises when connecting failed at once
        return True

    def _receive(self) -> bytes:
        try:
            data = self._connection().recv(PORT_READ_BYTES)
        except BlockingIOError:
            return b""
        if not data:
            raise PortError("the other end closed the connection")
        return data

    def _send(self, data: bytes) -> int:
        sent = self._connection().send(data)
        if sent < len(data):  # half a packet would spoil all that follow
            raise PortError("the other end does not accept data")
        return sent

    def _examine(self, now_ns: int) -> None:
        """Raise when the connection has been silent for too long: its other end may be gone without a word."""
        if self._silence_s and now_ns - self._received_ns > self._silence_s * NS:
            raise PortError(f"connected, but silent for {self._silence_s:g} s")
