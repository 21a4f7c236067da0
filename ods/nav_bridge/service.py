"""Wiring of the nav process: line and navigation source on one loop, `pose` out."""

import logging
import time

from ods.base import clock
from ods.base.geodesy import LocalFrame
from ods.nav_bridge.registry import make_link, make_source
from ods.nav_bridge.settings import NavConfig
from ods.nav_bridge.source import NOTHING_COMES
from ods.runtime.service import TICK_S, Service, Worker

GATHER_S = 0.0018
"""After the first frame of an epoch: six PDOs take 1.5 ms on a bus of 500 kbit/s, and cost half when read together."""
LATE_S = 0.0005
"""For what has not come by then."""


class NavWorker(Worker[NavConfig]):
    """Reads the line in the work loop itself and publishes each pose."""

    def __init__(self, service: Service, settings: NavConfig) -> None:
        super().__init__(service, settings)
        nav, counters = settings.nav, service.counters
        frame = LocalFrame(settings.site.latitude_deg, settings.site.longitude_deg)
        self._source = make_source(nav, frame, self._send, counters)
        self._gather_s = GATHER_S
        self._has_read = False
        self._tick_ns = 0
        self._link = make_link(nav, self._source, counters, self._opened, self._closing)

    def start(self) -> None:
        """Try the line once: bad settings end the process, a missing device does not."""
        for library in ("can", "canopen"):  # they log every attempt; `CanLink` and `problems` report what matters
            logging.getLogger(library).setLevel(logging.CRITICAL)
        self._link.tick()

    def readable(self, fd: int) -> None:
        """Let the rest of an epoch come, then read all of it: the less often the process wakes, the less it costs."""
        woken_ns = clock.monotonic_ns()
        time.sleep(self._gather_s)
        self._gather_s = LATE_S
        self._read(woken_ns)
        self._has_read = True

    def tick(self) -> None:
        """Read a line that cannot be polled; keep line and source going."""
        now_ns = clock.monotonic_ns()
        if not self._has_read:
            self._read(now_ns)
        self._has_read = False
        self._link.tick()
        if self._link.is_open and now_ns >= self._tick_ns:
            self._source.tick(now_ns)
            self._tick_ns = now_ns + round(self.wait_s() * clock.NS)

    def _read(self, woken_ns: int) -> None:
        for item in self._link.read(woken_ns):
            pose = self._source.take(item)
            if pose is not None:
                self._gather_s = GATHER_S
                self.service.publish("pose", pose)
                self.service.counters["poses"] += 1

    def wait_s(self) -> float:
        """Return the time until the source has to be on time with something."""
        idle_ns = self._source.idle_ns(clock.monotonic_ns()) if self._link.is_open else None
        return TICK_S if idle_ns is None else min(TICK_S, idle_ns / clock.NS)

    def ready(self) -> bool:
        """Return whether the line is open."""
        return self._link.is_open

    def problems(self) -> list[str]:
        """Return the problems of line, INS and pose, a text each."""
        line, source = self._link.problems(), self._source.problems(clock.monotonic_ns(), self.service.overload())
        if line and source and source[0].endswith(NOTHING_COMES):
            return [source[0].replace(NOTHING_COMES, "; ".join(line))]  # one cause
        return line + source

    def stop(self) -> None:
        """Give the line back."""
        self._link.close()

    def _send(self, can_id: int, data: bytes) -> None:
        self._link.send(can_id, data)

    def _opened(self, fd: int | None) -> None:
        if fd is not None:
            self.service.subscriber.watch_fd(fd)
        self._source.opened()

    def _closing(self, fd: int | None) -> None:
        if fd is not None:
            self.service.subscriber.unwatch_fd(fd)
