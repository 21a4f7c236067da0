"""A second connection to a sonar that takes its commands at another port than the one of its images."""

from collections import Counter

from ods.runtime.port.address import TcpAddress
from ods.runtime.port.tcp_port import TcpPort
from ods.sonar_link.protocol import SonarProtocol

MAX_READS = 16
"""Of answers in one turn, of 64 kB at most."""


class CommandLine:
    """Requests out, answers in, beside the stream. Never waits.

    Counters: control_unsent (requests that did not go out). Openings and losses are not counted: the port's are those
    of the stream.
    """

    def __init__(
        self, address: TcpAddress, protocol: SonarProtocol, pauses_s: tuple[float, float], counters: "Counter[str]"
    ) -> None:
        """`pauses_s`: shortest and longest pause before it is tried again."""
        self.counters = counters
        self._protocol = protocol
        self._port = TcpPort(address, 0.0, pauses_s)
        self._fault = ""

    def check(self, now_ns: int) -> None:
        """Open it if due, pass on received bytes, send due requests."""
        if self._port.open_if_due(now_ns):
            self._protocol.commands_open(now_ns)
        for _ in range(MAX_READS):
            data = self._port.read(now_ns)
            if not data:
                break
            self._protocol.answered(data, now_ns)
        if self._port.fd is not None:
            for request in self._protocol.requests(now_ns):
                self.counters["control_unsent"] += not self._port.write(request, now_ns)
        if self._port.fault and self._port.fault != self._fault:
            self._protocol.commands_lost(self._port.fault, now_ns)
        self._fault = self._port.fault

    def close(self) -> None:
        """Give the connection back."""
        self._port.close()
