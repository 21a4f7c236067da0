"""The bridge to ROS 2 as a process."""

from typing import Any

import cyclonedds  # noqa: F401  # before rosbags, so that it is this extra that is said to be missing

from ods.base import clock
from ods.bridge.extrapolated_list import ExtrapolatedList, is_finite
from ods.bridge.ros2 import content
from ods.bridge.ros2.sender import DdsSender
from ods.bridge.ros2.topics import wanted
from ods.bridge.settings import BridgeConfig, Ros2Settings
from ods.bridge.worker import STALE_NS, ListWorker
from ods.messages import Clearance, ObstacleList, Ping
from ods.ros2.clearance import cloud
from ods.ros2.messages import Frames, Messages
from ods.ros2.pictures import within
from ods.runtime.service import Service

DIAGNOSED_NS = clock.NS
"""Period of repeating a verdict, s; a changed one is sent at once."""


class Ros2Worker(ListWorker):
    """Writes lists, clear water and images, each if it is wanted, valid, and time.

    Counters: sent_lists, sent_messages, unheard_lists, left_out_obstacles, unfit_images, and those of `ListWorker` and
    `DdsSender`.
    """

    name = "ros2"

    def __init__(self, service: Service, settings: BridgeConfig) -> None:
        super().__init__(service, settings)
        table = self._table = self.table(Ros2Settings)
        self._make = Messages(Frames(table.map_frame, table.vehicle_frame))
        self._kinds: dict[str, str] = {row.key: row.kind for row in wanted(table)}
        self._sender = DdsSender(table, self._make.store, service.log_once)
        self._clearance: Clearance | None = None
        self._ping: Ping | None = None
        self._clearance_due_ns = self._image_due_ns = 0
        self._last: ObstacleList | None = None
        self._said, self._said_ns = "", 0
        for key, topic in (("clearance", "clearance"), ("image", "ping")):
            if key not in self._kinds:
                service.subscriber.unsubscribe(topic)

    def handle(self, topic: str, message: Any) -> None:
        """Keep the newest of each topic."""
        if topic == "obstacles":
            super().handle(topic, message)
        elif topic == "clearance":
            self._clearance = message
        else:
            self._ping = message

    def tick(self) -> None:
        """Send what is there, if it is time."""
        now_ns = clock.monotonic_ns()
        self._sender.look(now_ns)
        super().tick()
        self._send_clearance(now_ns)
        self._send_image(now_ns)
        self._send_verdict(now_ns)

    def judged(self, obstacle_list: ObstacleList, silent: str) -> None:
        """Keep what the verdict is about."""
        self._last = obstacle_list

    def send(self, extrapolated: ExtrapolatedList) -> None:
        """Write a list's messages, for the instant of sending; none is made without a subscriber."""
        counters = self.service.counters
        keys = [key for key in content.OF_LISTS if self._is_received(key)]
        if not keys:
            self.service.log_once("unheard_lists", self._sender.problem() or "no node has subscribed")
            return
        obstacle_list, stamp_ns = content.now(extrapolated, self._table.most_obstacles), extrapolated.utc_ns
        sent = [self._write(key, content.OF_LISTS[key](self._make, stamp_ns, obstacle_list)) for key in keys]
        counters["sent_lists"] += all(sent)
        counters["left_out_obstacles"] += extrapolated.left_out(len(obstacle_list.obstacles))

    def _is_received(self, key: str) -> bool:
        return key in self._kinds and self._sender.is_received(key)

    def _send_clearance(self, now_ns: int) -> None:
        water = self._clearance
        if water is None or now_ns < self._clearance_due_ns:
            return
        self._clearance = None
        if not self._is_received("clearance"):
            return
        fresh = now_ns - (water.made_ns or water.t_ns) <= STALE_NS
        if water.valid and fresh and water.pose is not None and is_finite(water.pose):
            self._clearance_due_ns = now_ns + self._period_ns
            self._write("clearance", cloud(self._make, water.utc_ns, water, water.pose))

    def _send_image(self, now_ns: int) -> None:
        ping = self._ping
        if ping is None or now_ns < self._image_due_ns:
            return
        self._ping = None
        if not self._is_received("image"):
            return
        self._image_due_ns = now_ns + round(clock.NS / self._table.image_hz)
        try:
            image = self._make.image(ping.utc_ns, within(ping, self._table.image_bytes))
        except ValueError as error:
            self.service.log_once("unfit_images", str(error))
            return
        self._write("image", image)

    def _send_verdict(self, now_ns: int) -> None:
        silent = self.silence(now_ns)
        said = silent.rstrip("0123456789. s") if silent.startswith("no obstacle list") else silent
        if "diagnostics" not in self._kinds or (said == self._said and now_ns - self._said_ns < DIAGNOSED_NS):
            return
        self._said, self._said_ns = said, now_ns
        obstacle_list = None if silent.startswith("no obstacle list") else self._last
        if obstacle_list is None and not silent:
            return
        age_s = 0.0 if obstacle_list is None else (now_ns - obstacle_list.t_ns) / clock.NS
        self._write("diagnostics", content.verdict(self._make, clock.utc_ns(now_ns), obstacle_list, silent, age_s))

    def _write(self, key: str, message: Any) -> bool:
        sent = self._sender.send(key, self._make.cdr(message, self._kinds[key]))
        self.service.counters["sent_messages"] += sent
        return sent

    def peer_problem(self, now_ns: int) -> str:
        """Return a text that the interface is away, or that no node has subscribed."""
        return self._sender.problem()

    def stop(self) -> None:
        """Leave the domain."""
        self._sender.close()
