"""The sonar process: bytes from the port to pings on the bus."""

import logging
import time

import msgspec

from ods import clock
from ods.bus import TOPICS
from ods.config import OnboardConfig
from ods.service import Service, Worker
from ods.sonar_link.assembler import Assembler
from ods.sonar_link.drf import Record
from ods.sonar_link.framer import Framer
from ods.sonar_link.serial_port import SerialPort

log = logging.getLogger(__name__)

MAX_READS = 16
"""Reads before the work loop gets its turn."""
GATHER_S = 0.008
"""Longest pause for bytes to gather in the port's buffer: fewer and larger reads."""
BITS_A_BYTE = 10
"""On a serial line: start, eight of data, stop."""
LOGGED = {
    "bad_beam_table", "bad_checksum", "bad_ping", "bad_settings", "bad_water_column", "data_without_geometry",
    "data_without_settings", "lost_pings", "no_device_time", "overlong_record", "ping_number_restarts", "port_losses",
    "unsupported_layout",
}  # fmt: skip
"""Counters whose first count is worth a line in the log."""


class SonarWorker(Worker[OnboardConfig]):
    """Reads the port, frames and joins the records, stamps and publishes the pings."""

    def __init__(self, service: Service, settings: OnboardConfig) -> None:
        super().__init__(service, settings)
        sonar = settings.sonar
        self._counters = service.counters
        self._port = SerialPort(sonar.port, sonar.baud, (sonar.reopen_min_s, sonar.reopen_max_s), self._counters)
        self._framer = Framer(sonar.max_record_bytes, self._counters)
        self._offset = clock.OffsetEstimator()
        self._assembler = Assembler(self._offset.map, round(sonar.latency_ms * 1e6), self._counters)
        self._record_timeout_ns = round(sonar.record_timeout_s * clock.NS)
        self._byte_s = BITS_A_BYTE / sonar.baud
        self._watched: int | None = None
        self._newest_ns = clock.monotonic_ns()
        self._logged: set[str] = set()

    def start(self) -> None:
        """Open the port if it is there."""
        self.tick()

    def readable(self, fd: int) -> None:
        """Read the port empty and publish the pings that this completes."""
        self._let_bytes_gather()
        for _ in range(MAX_READS):
            data = self._port.read(clock.monotonic_ns())
            if not data:
                break
            self._publish(self._framer.feed(data, clock.monotonic_ns()))
        self._follow_port()

    def _let_bytes_gather(self) -> None:
        """Sleep for as long as the line cannot have completed the record under way: this delays no ping."""
        time.sleep(min(GATHER_S, self._framer.missing_bytes * self._byte_s))

    def tick(self) -> None:
        """Reopen a lost port, give up a record that does not end, say what is new among the losses."""
        now = clock.monotonic_ns()
        self._port.check(now)
        self._port.open_if_due(now)
        self._follow_port()
        # one false header may be followed by others that have waited as long
        while (since := self._framer.waiting_since_ns) is not None and now - since > self._record_timeout_ns:
            self._publish(self._framer.give_up())
        self._counters["device_clock_jumps"] = self._offset.jumps
        self._counters["wild_device_times"] = self._offset.wild
        for name in LOGGED & (self._counters.keys() - self._logged):
            self._logged.add(name)
            log.warning("first %s (counted from now on)", name)

    def ready(self) -> bool:
        """Tell whether the port has been opened."""
        return self._counters["port_opens"] > 0

    def problems(self) -> list[str]:
        """Say whether the port is away or the sonar silent."""
        silence_s = (clock.monotonic_ns() - self._newest_ns) / clock.NS
        problems = [self._port.fault] if self._port.fault else []
        if silence_s > TOPICS["ping"].stale_s:
            problems.append(f"no ping for {silence_s:.1f} s")
        return problems

    def stop(self) -> None:
        """Close the port."""
        self._port.close()
        self._follow_port()

    def _publish(self, records: list[Record]) -> None:
        for record in records:
            ping = self._assembler.feed(record)
            if ping is not None:
                self._newest_ns = ping.t_rx_ns
                # the sonar's own UTC is no better than its clock; all messages of this machine share one UTC
                self.service.publish("ping", msgspec.structs.replace(ping, utc_ns=clock.utc_ns(ping.t_ns)))

    def _follow_port(self) -> None:
        """Let the work loop watch the port's descriptor as long as it is open; end the stream with it."""
        fd = self._port.fd
        if fd == self._watched:
            return
        if self._watched is not None:
            self.service.subscriber.unwatch_fd(self._watched)
            self._publish(self._framer.flush())
        if fd is not None:
            self.service.subscriber.watch_fd(fd)
        self._watched = fd
