"""The line to a navigation system that sends text: a serial device, a serial server, or a UDP port."""

from collections import Counter
from collections.abc import Iterator

from ods.base import clock
from ods.nav_bridge.link import Descriptor, Link
from ods.nav_bridge.nmea.line import Line, LineSplitter
from ods.nav_bridge.settings import NmeaSettings
from ods.runtime.port.address import tcp_address, udp_address
from ods.runtime.port.port import Port
from ods.runtime.port.serial_port import SerialPort
from ods.runtime.port.tcp_port import TcpPort
from ods.runtime.port.udp_port import UdpPort

PAUSES_S = (0.1, 1.0)
"""Shortest and longest between two attempts to open it."""
SILENCE_S = 5.0
"""Silence after which a serial server counts as gone, s."""
MOST_READS = 64
"""In one go: a flood leaves time for the rest of the loop."""


class NmeaLink(Link[Line]):
    """One line, kept open. Counts `line_overlong`, `stranger_datagrams`, and what `Port` does."""

    def __init__(self, settings: NmeaSettings, counters: Counter[str], opened: Descriptor, closing: Descriptor) -> None:
        self._port = _port(settings, counters)
        self._look_at = settings.look_at
        self._splitter = LineSplitter(counters)
        self._opened, self._closing = opened, closing
        self._fd: int | None = None

    @property
    def is_open(self) -> bool:
        """Return whether the line is open."""
        return self._port.fd is not None

    def tick(self) -> None:
        """Open the line when it is due, give it up when it is not what it was."""
        now_ns = clock.monotonic_ns()
        self._port.check(now_ns)
        self._follow()
        if self._port.open_if_due(now_ns):
            self._splitter.forget()
        self._follow()

    def read(self, woken_ns: int) -> Iterator[Line]:
        """Yield the lines that have arrived."""
        for _ in range(MOST_READS):
            data = self._port.read(woken_ns)
            self._follow()
            if not data:
                return
            yield from self._splitter.feed(data, woken_ns)

    def problems(self) -> list[str]:
        """Return why it is not open, or that the data have no line ends."""
        if self._port.fault:
            return [self._port.fault]
        endless = f"the data received have no line ends: {self._look_at}"
        return [endless] if self._splitter.endless else []

    def close(self) -> None:
        """Close the line."""
        self._port.close()
        self._follow()

    def _follow(self) -> None:
        """Report another descriptor to the owner."""
        before, self._fd = self._fd, self._port.fd
        if before == self._fd:
            return
        if before is not None:
            self._closing(before)
        if self._fd is not None:
            self._opened(self._fd)


def _port(settings: NmeaSettings, counters: Counter[str]) -> Port:
    udp, tcp = udp_address(settings.port), None
    if udp is not None:
        return UdpPort(udp, settings.sender, PAUSES_S, counters)
    tcp = tcp_address(settings.port)
    if tcp is not None:
        return TcpPort(tcp, SILENCE_S, PAUSES_S, counters)
    return SerialPort(settings.port, settings.baud, PAUSES_S, counters)
