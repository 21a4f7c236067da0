"""The sonar process: bytes from the port to pings on the bus, and requests to the sonar."""

import logging
import time
from collections import Counter

import msgspec

from ods.base import clock
from ods.messages import Ping, SonarRequest
from ods.runtime.counters import logged_names, trouble_names
from ods.runtime.ping_pace import PingPace
from ods.runtime.raw_bytes import RawBytes
from ods.runtime.service import Service, Worker
from ods.sonar_link.link import SonarLink
from ods.sonar_link.planner_requests import PlannerRequests
from ods.sonar_link.registry import make_protocol
from ods.sonar_link.settings import SonarConfig

log = logging.getLogger(__name__)

MAX_READS = 16
"""Largest number of reads before the work loop continues."""
LONGEST_READING_S = 0.2
"""Longest time of reading before the work loop continues: false headers take time, and health has a watchdog."""
LOGGED = logged_names("sonar")
"""Counters whose first count is worth a line in the log."""
LOSSES = frozenset(name for name in trouble_names("sonar") if not name.startswith(("port_", "control_")))
"""Counters that show why the data received are no ping."""


class SonarWorker(Worker[SonarConfig]):
    """Lets the line work and publishes its pings; takes the requests of planners."""

    def __init__(self, service: Service, settings: SonarConfig) -> None:
        super().__init__(service, settings)
        sonar = settings.sonar
        self._counters = service.counters
        self._protocol = make_protocol(sonar, self._counters)
        self._link = SonarLink(sonar, self._protocol, self._counters)
        self._planners = PlannerRequests(self._protocol.setting_requests, sonar.control_patience_s, service.answer)
        self._watched: int | None = None
        self._reads = 0
        self._newest_ns = clock.monotonic_ns()
        self._pace = PingPace()
        self._counted_by_then: Counter[str] = Counter()
        self._logged: set[str] = set()

    def start(self) -> None:
        """Open the port if it is there."""
        self.tick()

    def readable(self, fd: int) -> None:
        """Read the port empty, if that does not take too long, and publish the pings that this completes."""
        time.sleep(self._link.gather_s)
        end_s = time.monotonic() + LONGEST_READING_S
        for _ in range(MAX_READS):
            if time.monotonic() > end_s:
                break
            pings = self._link.read(clock.monotonic_ns())
            if pings is None:
                break
            if self.settings.sonar.publish_raw:
                self.service.publish("raw", RawBytes(self._reads, clock.monotonic_ns(), self._link.newest))
                self._reads += 1
            self._publish(pings)
        self._follow_port()

    def asked(self, peer: list[bytes], request: SonarRequest) -> None:
        """Take a planner's request."""
        self._planners.take(peer, request, clock.monotonic_ns())

    def tick(self) -> None:
        """Reopen a lost port, send due requests, log new losses."""
        now = clock.monotonic_ns()
        self._publish(self._link.check(now))
        self._follow_port()
        self._planners.answer(now)
        for name in LOGGED & ((+self._counters).keys() - self._logged):
            self._logged.add(name)
            log.warning("first %s (logged once, then counted)", name)

    def ready(self) -> bool:
        """Return whether the port has been opened."""
        return self._counters["port_opens"] > 0

    def problems(self) -> list[str]:
        """Return whether the port is away, the sonar silent or disobedient."""
        now = clock.monotonic_ns()
        silence_s = (now - self._newest_ns) / clock.NS
        silence = [f"no ping for {silence_s:.1f} s{self._lost()}"] if silence_s > self._pace.patience_s else []
        return self._link.faults + silence + self._protocol.problems(now)

    def _lost(self) -> str:
        """Return what came in place of pings since the newest one, or that the computer is overloaded; '' if neither.

        The overload hides no other cause: the list has both.
        """
        if self._link.fd is None:  # its fault says why
            return ""
        lost = LOSSES & (self._counters - self._counted_by_then).keys()
        if lost:
            return f", though other data arrive: {', '.join(sorted(lost))}"
        overload = self.service.overload()
        return f": {overload}" if overload else ""

    def stop(self) -> None:
        """Close the port."""
        self._publish(self._link.close(clock.monotonic_ns()))
        self._follow_port()

    def _publish(self, pings: list[Ping]) -> None:
        for ping in pings:
            self._newest_ns = ping.t_rx_ns
            self._pace.ping(ping.t_ns)
            self._counted_by_then = Counter(self._counters)
            # the sonar's own UTC is no better than its clock; all messages of this machine share one UTC
            self.service.publish("ping", msgspec.structs.replace(ping, utc_ns=clock.utc_ns(ping.t_ns)))

    def _follow_port(self) -> None:
        """Let the work loop watch the port's descriptor as long as it is open."""
        fd = self._link.fd
        if fd == self._watched:
            return
        if self._watched is not None:
            self.service.subscriber.unwatch_fd(self._watched)
        if fd is not None:
            self.service.subscriber.watch_fd(fd)
        self._watched = fd
