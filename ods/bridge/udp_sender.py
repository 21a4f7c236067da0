"""Sends datagrams to one receiver, and continues after errors."""

import ipaddress
import socket
from collections.abc import Callable

from ods.base import clock
from ods.base.errors import reason_of
from ods.bridge.settings import Destination

REPORTED_NS = 2 * clock.NS
"""Time for which a refusal is reported, ns: an absent receiver refuses only now and then."""


class UdpSender:
    """A socket to the destination, made again after errors: the interface may have got another address.

    `log_once`: counts under a name, and logs the text once. Names: `refused_datagrams` (the receiver's computer
    reports that the port is closed), `unsent_datagrams` (no route, or a full buffer).
    """

    def __init__(self, to: Destination, log_once: Callable[[str, str], None]) -> None:
        self._to = to
        self._log_once = log_once
        self._socket: socket.socket | None = None
        self._problem, self._problem_ns = "", 0

    def send(self, datagrams: list[bytes]) -> int:
        """Send each at once or not at all; return how many were sent."""
        return sum(map(self._sent, datagrams))

    def _sent(self, data: bytes) -> bool:
        try:
            self._send(data)
        except OSError as error:
            self._note("unsent_datagrams", reason_of(error))
            self.close()
            return False
        return True

    def _send(self, data: bytes) -> None:
        """Raises OSError."""
        connected = self._connected()
        try:
            connected.send(data)
        except ConnectionRefusedError:  # of an earlier one: this one was not sent
            self._note("refused_datagrams", "no process listens there")
            connected.send(data)

    def _connected(self) -> socket.socket:
        if self._socket is None:
            family = socket.AF_INET6 if ipaddress.ip_address(self._to.host).version == 6 else socket.AF_INET
            self._socket = socket.socket(family, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK)
            self._socket.connect(self._to)
        return self._socket

    def _note(self, name: str, why: str) -> None:
        self._problem, self._problem_ns = f"{self._to.host} port {self._to.port}: {why}", clock.monotonic_ns()
        self._log_once(name, self._problem)

    def problem(self, now_ns: int) -> str:
        """Return what is wrong now, in plain words, or ""."""
        return self._problem if now_ns - self._problem_ns < REPORTED_NS else ""

    def close(self) -> None:
        """Give the socket back."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
