"""Wiring of the nav process: CAN bus, receiver and own node on one loop, `pose` out."""

import logging

from ods import clock
from ods.config import OnboardConfig
from ods.nav_bridge.can_link import CanLink
from ods.nav_bridge.ins_monitor import PRE_OPERATIONAL
from ods.nav_bridge.own_node import OwnNode
from ods.nav_bridge.pdo_layout import load_pdo_set
from ods.nav_bridge.receiver import InsReceiver
from ods.service import Service, Worker

START_PERIOD_NS = clock.NS
"""Between two commands that start the INS."""


class NavWorker(Worker[OnboardConfig]):
    """Reads the CAN bus in the work loop itself and publishes a pose an epoch."""

    def __init__(self, service: Service, settings: OnboardConfig) -> None:
        super().__init__(service, settings)
        nav, counters = settings.nav, service.counters
        pdo_set = load_pdo_set(nav.ins_eds, nav.ins_node_id)
        self._receiver = InsReceiver(nav, pdo_set, clock.monotonic_ns(), clock.utc_ns, counters)
        self._node = OwnNode(nav, self._send, counters)
        ids = self._receiver.ids | self._node.ids
        self._link = CanLink(nav.can, ids, counters, self._opened, self._closing)
        self._commanded_ns = 0

    def start(self) -> None:
        """Try the interface once: bad settings end the process, a missing device does not."""
        for library in ("can", "canopen"):  # they tell every attempt; `CanLink` and `problems` tell what matters
            logging.getLogger(library).setLevel(logging.CRITICAL)
        self._link.tick()

    def tick(self) -> None:
        """Read the bus empty, whatever woke the loop; keep bus, heartbeat and, if that is our job, INS going."""
        for frame in self._link.read():
            pose = self._receiver.take(frame)
            if pose is not None:
                self.service.publish("pose", pose)
                self.service.counters["poses"] += 1
            else:
                self._node.take(frame)
        self._link.tick()
        if not self._link.is_open:
            return
        now_ns = clock.monotonic_ns()
        self._node.tick(now_ns)
        wanted = self.settings.nav.start_ins and self._receiver.monitor.state == PRE_OPERATIONAL
        if wanted and now_ns - self._commanded_ns > START_PERIOD_NS:
            self._commanded_ns = now_ns
            self._node.start_remote(self.settings.nav.ins_node_id)

    def ready(self) -> bool:
        """Tell whether the bus is open."""
        return self._link.is_open

    def problems(self) -> list[str]:
        """Say what is wrong with bus, INS and pose."""
        return self._link.problems() + self._receiver.problems(clock.monotonic_ns())

    def stop(self) -> None:
        """Give the interface back."""
        self._link.close()

    def _send(self, can_id: int, data: bytes) -> None:
        self._link.send(can_id, data)

    def _opened(self, fd: int | None) -> None:
        if fd is not None:
            self.service.subscriber.watch_fd(fd)
        self._node.boot()

    def _closing(self, fd: int | None) -> None:
        if fd is not None:
            self.service.subscriber.unwatch_fd(fd)
