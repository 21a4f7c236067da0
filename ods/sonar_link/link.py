"""The line to the sonar: its port, those of its announcements and commands if it has them, and the protocol spoken."""

from collections import Counter

from ods.messages import Ping
from ods.runtime.port.address import tcp_address, udp_address
from ods.runtime.port.datagram_port import DatagramPort
from ods.runtime.port.port import Port
from ods.runtime.port.serial_port import SerialPort
from ods.runtime.port.tcp_port import TcpPort
from ods.runtime.port.udp_listener import UdpListener
from ods.runtime.port.udp_peer_port import UdpPeerPort
from ods.sonar_link.command_line import CommandLine
from ods.sonar_link.protocol import SonarProtocol
from ods.sonar_link.settings import SonarSettings

LONGEST_GATHER_S = 0.008
"""Longest pause for bytes to gather in the port's buffer: fewer and larger reads."""
BITS_A_BYTE = 10
"""On a serial line: start, eight of data, stop."""


class SonarLink:
    """Pings in, requests out. Never waits. Counter: control_unsent (requests that did not go out)."""

    def __init__(self, settings: SonarSettings, protocol: SonarProtocol, counters: "Counter[str]") -> None:
        self.counters = counters
        self.octets = 0
        """Bytes read so far."""
        self.newest = b""
        """Bytes of the last read."""
        address = tcp_address(settings.port)
        pauses_s = settings.reopen_min_s, settings.reopen_max_s
        self._protocol = protocol
        self._port = _port(settings, protocol, pauses_s, counters)
        self._side = UdpListener(protocol.side_port) if protocol.side_port is not None else None
        commands = protocol.command_port if address else None
        self._commands = (
            CommandLine(address._replace(port=commands), protocol, pauses_s, counters) if address and commands else None
        )
        self._byte_s = BITS_A_BYTE / settings.baud if isinstance(self._port, SerialPort) else 0.0
        self._streaming = False

    @property
    def fd(self) -> int | None:
        """The descriptor to poll, None when the line is away."""
        return self._port.fd

    @property
    def faults(self) -> list[str]:
        """Why the line is away, or the sonar's announcements cannot be received, in plain words."""
        faults = self._port.fault, self._side.fault if self._side else ""
        return [fault for fault in faults if fault]

    @property
    def gather_s(self) -> float:
        """For how long the line cannot have completed the ping under way: a pause of this length delays none."""
        return min(LONGEST_GATHER_S, self._protocol.missing_bytes * self._byte_s)

    def read(self, now_ns: int) -> list[Ping] | None:
        """Return the pings that the next bytes complete; None when no byte has come."""
        data = self._port.read(now_ns)
        if not data:
            return None
        self.octets += len(data)
        self.newest = data
        return self._protocol.feed(data, now_ns)

    def check(self, now_ns: int) -> list[Ping]:
        """Listen to announcements, give up a line that has gone, open one whose time has come, send what is due.

        Returns the pings found in what is left of a lost stream, and behind telegrams that do not end.
        """
        for datagram in self._side.receive(now_ns) if self._side else []:
            self._protocol.received(datagram.data, datagram.sender, now_ns)
        self._port.check(now_ns)
        pings = self._end_lost_stream(now_ns) + self._protocol.check(now_ns)
        if self._port.open_if_due(now_ns):
            self._streaming = True
            self._protocol.connected(now_ns)
        if self._commands is not None:
            self._commands.check(now_ns)
        elif self._port.fd is not None:
            for request in self._protocol.requests(now_ns):
                self.counters["control_unsent"] += not self._port.write(request, now_ns)
        return pings

    def close(self, now_ns: int) -> list[Ping]:
        """Close the line; return the pings found in what is left of the stream."""
        self._port.close()
        if self._side is not None:
            self._side.close()
        if self._commands is not None:
            self._commands.close()
        return self._end_lost_stream(now_ns)

    def _end_lost_stream(self, now_ns: int) -> list[Ping]:
        if not self._streaming or self._port.fd is not None:
            return []
        self._streaming = False
        return self._protocol.end_stream(now_ns)


def _port(
    settings: SonarSettings, protocol: SonarProtocol, pauses_s: tuple[float, float], counters: "Counter[str]"
) -> Port:
    tcp, udp = tcp_address(settings.port), udp_address(settings.port)
    if tcp:
        return TcpPort(tcp, settings.silence_s, pauses_s, counters)
    if udp and protocol.datagrams:
        return DatagramPort(udp, protocol.datagrams, pauses_s, counters)
    if udp:
        return UdpPeerPort(udp, settings.silence_s, pauses_s, counters)
    return SerialPort(settings.port, settings.baud, pauses_s, counters, protocol.wake)
