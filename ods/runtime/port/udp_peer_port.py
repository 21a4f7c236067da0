"""Datagrams to and from one address, as a port: a byte stream whose pieces may be lost."""

import ipaddress
import socket
from collections import Counter

from ods.base.clock import NS
from ods.runtime.port.address import UdpAddress
from ods.runtime.port.port import PORT_READ_BYTES, PortError
from ods.runtime.port.socket_port import SocketPort


class UdpPeerPort(SocketPort):
    """A socket that receives from one peer only, opened again when that is silent for `silence_s` (0: it may be
    silent)."""

    def __init__(
        self,
        address: UdpAddress,
        silence_s: float,
        pauses_s: tuple[float, float],
        counters: "Counter[str] | None" = None,
    ) -> None:
        """Make a closed port; pauses_s: shortest and longest pause before it is tried again."""
        super().__init__(f"{address.host} UDP port {address.port}", pauses_s, counters)
        self._address = address
        self._silence_s = silence_s

    def _begin_opening(self, _now_ns: int) -> None:
        version = ipaddress.ip_address(self._address.host).version
        family = socket.AF_INET6 if version == 6 else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK)
        self._socket.connect(self._address)  # nothing is sent: from now on only this peer is received

    def _receive(self) -> bytes:
        try:
            return self._connection().recv(PORT_READ_BYTES)
        except BlockingIOError:
            return b""

    def _send(self, data: bytes) -> int:
        return self._connection().send(data)

    def _examine(self, now_ns: int) -> None:
        """Raise the error that the socket reports, such as a closed port at the peer, or the peer's silence."""
        self._raise_error()
        if self._silence_s and now_ns - self._received_ns > self._silence_s * NS:
            raise PortError(f"silent for {self._silence_s:g} s")
