"""Hears datagrams, broadcast ones too, at one UDP port of every network interface."""

import socket
from typing import NamedTuple

from ods.base.clock import NS

MAX_DATAGRAMS = 64
"""Read at one go: a flood of them holds nothing up."""
DATAGRAM_BYTES = 65536
RETRY_NS = NS


class Datagram(NamedTuple):
    """A received datagram."""

    data: bytes
    sender: str
    """IP address."""


class UdpListener:
    """Shares its port with other listeners of this machine that allow it. Never waits."""

    def __init__(self, port: int) -> None:
        self.fault = ""
        """Why nothing can be received, in plain words; '' when something can."""
        self._port = port
        self._socket: socket.socket | None = None
        self._due_ns = 0

    def receive(self, now_ns: int) -> list[Datagram]:
        """Return the datagrams that have come; open the port first, or try again a second after that failed."""
        if self._socket is None and now_ns < self._due_ns:
            return []
        try:
            if self._socket is None:
                self._open()
            return self._received()
        except OSError as error:
            self.close()
            self.fault = f"UDP port {self._port}: {error.strerror}"
            self._due_ns = now_ns + RETRY_NS
            return []

    def close(self) -> None:
        """Give the port back."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _open(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.bind(("", self._port))
        self.fault = ""

    def _received(self) -> list[Datagram]:
        assert self._socket is not None
        found: list[Datagram] = []
        while len(found) < MAX_DATAGRAMS:
            try:
                data, sender = self._socket.recvfrom(DATAGRAM_BYTES)
            except BlockingIOError:
                break
            found.append(Datagram(data, sender[0]))
        return found
