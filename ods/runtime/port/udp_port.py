"""Datagrams of lines at one UDP port, as a port: each is taken for whole lines."""

import ipaddress
import socket
from collections import Counter
from typing import ClassVar

from ods.runtime.port.address import UdpAddress
from ods.runtime.port.port import PORT_READ_BYTES, PortError
from ods.runtime.port.socket_port import SocketPort


class UdpPort(SocketPort):
    """Takes datagrams of anybody, or of one sender only. Counts `stranger_datagrams`, of others."""

    ending: ClassVar[bytes] = b"\n"
    """Behind each."""

    def __init__(
        self, address: UdpAddress, sender: str | None, pauses_s: tuple[float, float], counters: "Counter[str]"
    ) -> None:
        """Make a closed port; pauses_s: shortest and longest pause before it is tried again."""
        super().__init__(f"UDP port {address.port}", pauses_s, counters)
        self._address, self._sender = address, sender

    def _begin_opening(self, _now_ns: int) -> None:
        version = ipaddress.ip_address(self._address.host).version
        family = socket.AF_INET6 if version == 6 else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK)
        self._socket.bind(self._address)

    def _receive(self) -> bytes:
        try:
            data, (sender, *_) = self._connection().recvfrom(PORT_READ_BYTES)
        except BlockingIOError:
            return b""
        if self._sender not in (None, sender):
            self.counters["stranger_datagrams"] += 1
            return self.ending
        return data + self.ending

    def _send(self, data: bytes) -> int:
        raise PortError(f"nothing is sent here: {len(data)} bytes")

    def _examine(self, now_ns: int) -> None:
        """Raise what the socket has to tell."""
        self._raise_error()
