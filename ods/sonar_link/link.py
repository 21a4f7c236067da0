"""The line to the sonar as one thing: the port, the network frames where it has them, and the record framer."""

from collections import Counter

from ods.sonar_link.port.address import tcp_address
from ods.sonar_link.port.port import NS, Port
from ods.sonar_link.port.serial_port import SerialPort
from ods.sonar_link.port.tcp_port import TcpPort
from ods.sonar_link.s7k.drf import Record
from ods.sonar_link.s7k.framer import Framer
from ods.sonar_link.s7k.network_frame import Deframer, frame_record
from ods.sonar_link.settings import SonarSettings

GATHER_S = 0.008
"""Longest pause for bytes to gather in the port's buffer: fewer and larger reads."""
BITS_A_BYTE = 10
"""On a serial line: start, eight of data, stop."""


class SonarLink:
    """Records in, requests out. Never waits."""

    def __init__(self, settings: SonarSettings, counters: "Counter[str]") -> None:
        self.counters = counters
        address = tcp_address(settings.port)
        pauses_s = settings.reopen_min_s, settings.reopen_max_s
        self._port: Port = (
            TcpPort(address, settings.silence_s, pauses_s, counters)
            if address
            else SerialPort(settings.port, settings.baud, pauses_s, counters)
        )
        framed = address is not None and address.framed
        self._deframer = Deframer(settings.max_record_bytes, counters) if framed else None
        self._framer = Framer(settings.max_record_bytes, counters)
        self._record_timeout_ns = round(settings.record_timeout_s * NS)
        self._transmissions = 0
        self._byte_s = 0.0 if address else BITS_A_BYTE / settings.baud

    @property
    def fd(self) -> int | None:
        """The descriptor to poll, None when the line is away."""
        return self._port.fd

    @property
    def fault(self) -> str:
        """Why the line is away, in plain words; '' when it is not."""
        return self._port.fault

    def open_if_due(self, now_ns: int) -> bool:
        """Try to open a line that is away; tell whether it is there now and was not before."""
        return self._port.open_if_due(now_ns)

    @property
    def gather_s(self) -> float:
        """For how long the line cannot have completed the record under way: to pause so long delays no ping."""
        return min(GATHER_S, self._framer.missing_bytes * self._byte_s)

    def read(self, now_ns: int) -> list[Record] | None:
        """Return the records that the next bytes complete; None when no byte has come."""
        data = self._port.read(now_ns)
        if not data:
            return None
        return self._framer.feed(self._deframer.feed(data) if self._deframer else data, now_ns)

    def check(self, now_ns: int) -> list[Record]:
        """Give up a line that has gone and records that do not end; return the records found behind those."""
        self._port.check(now_ns)
        records = []
        while (since := self._framer.waiting_since_ns) is not None and now_ns - since > self._record_timeout_ns:
            records += self._framer.give_up()
        return records

    def end_stream(self, now_ns: int) -> list[Record]:
        """Take what is left of the stream of a line that was lost; return the records found in it."""
        records = self._framer.feed(self._deframer.flush(), now_ns) if self._deframer else []
        return records + self._framer.flush()

    def send(self, record: bytes, now_ns: int) -> bool:
        """Send one framed record; tell whether all of it went out."""
        if self._deframer:
            self._transmissions += 1
            record = frame_record(record, self._transmissions)
        return self._port.write(record, now_ns)

    def close(self) -> None:
        """Close the line."""
        self._port.close()
