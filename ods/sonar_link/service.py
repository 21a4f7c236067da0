"""The sonar process: bytes from the port to pings on the bus, and requests to the sonar."""

import logging
import time
from collections import Counter

import msgspec

from ods.base import clock
from ods.config import OnboardConfig
from ods.messages import SonarRequest
from ods.runtime.bus import TOPICS
from ods.runtime.service import Service, Worker
from ods.sonar_link.control import KNOBS, SonarControl
from ods.sonar_link.link import SonarLink
from ods.sonar_link.planner_requests import PlannerRequests
from ods.sonar_link.port.address import tcp_address
from ods.sonar_link.s7k import records, remote_control
from ods.sonar_link.s7k.assembler import Assembler, TimeMap
from ods.sonar_link.s7k.drf import Record
from ods.sonar_link.s7k.water_column import RecordError
from ods.sonar_link.settings import SonarSettings

log = logging.getLogger(__name__)

MAX_READS = 16
"""Reads before the work loop gets its turn."""
REPLIES = {remote_control.ACKNOWLEDGED, remote_control.REFUSED}
LOGGED = {
    "bad_beam_table", "bad_checksum", "bad_ping", "bad_remote_control", "bad_settings", "bad_water_column",
    "control_lost", "control_refused", "control_unsent", "data_without_geometry", "data_without_settings",
    "lost_pings", "no_device_time", "overlong_record", "ping_number_restarts", "port_losses", "unframed_bytes",
    "unsupported_layout",
}  # fmt: skip
"""Counters whose first count is worth a line in the log."""


class SonarWorker(Worker[OnboardConfig]):
    """Reads the line, joins the records, stamps and publishes the pings; sends what the sonar is to do."""

    def __init__(self, service: Service, settings: OnboardConfig) -> None:
        super().__init__(service, settings)
        sonar = settings.sonar
        self._counters = service.counters
        self._link = SonarLink(sonar, self._counters)
        self._assembler = Assembler(self._new_time_map, round(sonar.latency_ms * 1e6), self._counters)
        self._control = _control(sonar, self._counters)
        self._planners = PlannerRequests(self._control, sonar.control_patience_s, service.answer)
        self._sonar = records.DEVICE, 0
        self._watched: int | None = None
        self._newest_ns = clock.monotonic_ns()
        self._logged: set[str] = set()

    def start(self) -> None:
        """Open the port if it is there."""
        self.tick()

    def readable(self, fd: int) -> None:
        """Read the port empty and publish the pings that this completes."""
        time.sleep(self._link.gather_s)
        for _ in range(MAX_READS):
            records = self._link.read(clock.monotonic_ns())
            if records is None:
                break
            self._take(records)
        self._follow_port()

    def asked(self, peer: list[bytes], request: SonarRequest) -> None:
        """Take a planner's request."""
        self._planners.take(peer, request, clock.monotonic_ns())

    def tick(self) -> None:
        """Reopen a lost port, send what the sonar is to do, say what is new among the losses."""
        now = clock.monotonic_ns()
        self._take(self._link.check(now))
        if self._link.open_if_due(now):
            self._control.connected()
        self._follow_port()
        if self._link.fd is not None:
            self._send_requests(now)
        self._planners.answer(now)
        for name in LOGGED & ((+self._counters).keys() - self._logged):
            self._logged.add(name)
            log.warning("first %s (counted from now on)", name)

    def ready(self) -> bool:
        """Tell whether the port has been opened."""
        return self._counters["port_opens"] > 0

    def problems(self) -> list[str]:
        """Say whether the port is away, the sonar silent or disobedient."""
        silence_s = (clock.monotonic_ns() - self._newest_ns) / clock.NS
        problems = [self._link.fault] if self._link.fault else []
        if silence_s > TOPICS["ping"].stale_s:
            problems.append(f"no ping for {silence_s:.1f} s")
        return problems + self._control.problems()

    def stop(self) -> None:
        """Close the port."""
        self._link.close()
        self._follow_port()

    def _new_time_map(self) -> TimeMap:
        """Return the map of one sonar's clock; all of them count together."""
        estimator = clock.OffsetEstimator()

        def map_time(device_ns: int, arrival_ns: int) -> int:
            jumps, wild = estimator.jumps, estimator.wild
            t_ns = estimator.map(device_ns, arrival_ns)
            self._counters["device_clock_jumps"] += estimator.jumps - jumps
            self._counters["wild_device_times"] += estimator.wild - wild
            return t_ns

        return map_time

    def _take(self, records: list[Record]) -> None:
        for record in records:
            try:
                self._listen(record)
            except RecordError as reason:
                self._counters[str(reason)] += 1
                continue
            ping = None if record.record_type in REPLIES else self._assembler.feed(record)
            if ping is not None:
                self._newest_ns = ping.t_rx_ns
                # the sonar's own UTC is no better than its clock; all messages of this machine share one UTC
                self.service.publish("ping", msgspec.structs.replace(ping, utc_ns=clock.utc_ns(ping.t_ns)))

    def _listen(self, record: Record) -> None:
        """Take what a record says of the sonar's own state. Raises RecordError."""
        if record.record_type in REPLIES:
            self._control.answered(remote_control.decode_reply(record))
        elif record.record_type == records.SONAR_SETTINGS:
            settings = records.decode(record)
            if isinstance(settings, records.SonarSettings):
                self._sonar = record.device, record.enumerator
                self._control.hear(settings.controls, record.last_ns)

    def _send_requests(self, now_ns: int) -> None:
        for request in self._control.requests(now_ns):
            record = remote_control.encode_request(request, clock.utc_ns(now_ns), *self._sonar)
            self._counters["control_unsent"] += not self._link.send(record, now_ns)

    def _follow_port(self) -> None:
        """Let the work loop watch the port's descriptor as long as it is open; end the stream with it."""
        fd = self._link.fd
        if fd == self._watched:
            return
        if self._watched is not None:
            self.service.subscriber.unwatch_fd(self._watched)
            self._take(self._link.end_stream(clock.monotonic_ns()))
        if fd is not None:
            self.service.subscriber.watch_fd(fd)
        self._watched = fd


def _control(sonar: SonarSettings, counters: "Counter[str]") -> SonarControl:
    address = tcp_address(sonar.port)
    wanted = records.SONAR_SETTINGS, records.BEAM_GEOMETRY, sonar.samples_record
    return SonarControl(
        {name: value for name in KNOBS if (value := getattr(sonar, name)) is not None},
        repeat_s=sonar.control_repeat_s,
        attempts=sonar.control_attempts,
        records=wanted if address and address.framed else (),
        counters=counters,
    )
