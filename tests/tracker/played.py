"""The other processes of the chain, played, around a tracker process: real ZeroMQ on both sides."""

import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import zmq

from ods.base import clock
from ods.messages import Clearance, Detection, Detections, Health, ObstacleList, Pose
from ods.runtime import bus
from tests.tracker.samples import SECTOR

PROGRAM = """
import json
import sys
from pathlib import Path

import msgspec

from ods.base.geodesy import SiteSettings
from ods.runtime import service
from ods.runtime.bus import BusSettings
from ods.pose.buffer import PoseSettings
from ods.runtime.processes import PROCESSES
from ods.tracker.service import TrackerWorker
from ods.tracker.settings import TrackerProcessConfig, TrackerSettings

folder, tracker = Path(sys.argv[1]), json.loads(sys.argv[2])
site = SiteSettings(latitude_deg=57.0, longitude_deg=10.0)
tracker = msgspec.convert(tracker, TrackerSettings, dec_hook=lambda kind, path: folder / path)
bus = BusSettings(run_dir=folder, keys=folder / "keys")
config = TrackerProcessConfig(site=site, pose=PoseSettings(), tracker=tracker, bus=bus)
service.run_worker(TrackerWorker, PROCESSES["tracker"], folder, config)
"""
SETTINGS = {"map": {"path": "map.sqlite"}, "planner": {"period_s": 0.1}}
PATIENCE_S = 60.0
"""The very first start on a machine compiles."""
MS = 1_000_000
SOUND = 1480.0
Echoes = list[tuple[float, float]]
"""Ranges and bearings."""
ECHOES = (40.0, 0.0), (60.0, 0.3)
LISTENING_NS = 140 * MS
"""Longer than the farthest echo needs."""


class Chain:
    """The other processes, played: poses, detections and health, as long as they are wanted; and the planner."""

    def __init__(self, folder: Path, settings: Mapping[str, object], environment: Mapping[str, str]) -> None:
        """`settings`: what SETTINGS leave out of `[tracker]`; `environment`: what the tracker's has beside our own."""
        self.folder = folder
        self.lists: list[ObstacleList] = []
        self.clearances: list[Clearance] = []
        self.health: Health | None = None
        self.alive = {"sonar", "pipeline", "nav"}
        self.problems: dict[str, list[str]] = {}
        self.poses = self.pings = True
        self.last_pose = -1
        """`Pose.seq` of the newest one sent."""
        self.place = (0.0, 0.0, 4.0)
        """Where the INS says that the vehicle began,"""
        self.north_mps, self.range_scale = 0.0, 1.0
        """how fast it moves from then on,"""
        self._north = 0.0
        """and how far it came; `echoes` are seen from where it began."""
        self._posed_ns = clock.monotonic_ns()
        self.ins_turned_rad = 0.0
        """By so much is the heading wrong,"""
        self.ins_drift = 0.0
        """and it drifts by so much a second from now on."""
        self.ahead_ns = 0
        """Poses are stamped so much later than they are."""
        self.echoes: Echoes = list(ECHOES)
        self.heading: Callable[[float], float] = lambda _: 0.0
        """Of the vehicle, rad, at a time in s. `echoes` are seen from heading 0."""
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._publishers = {name: bus.Publisher(self._context, folder, name) for name in ("sonar", "pipeline", "nav")}
        self._subscriber = bus.Subscriber(self._context, folder, ["obstacles", "clearance"], ["tracker"])
        self._count = 0
        self._environment = os.environ | environment
        self.settings: dict[str, object] = SETTINGS | dict(settings)
        self.start()

    def start(self) -> None:
        """Start a tracker; what a former one said is forgotten."""
        self._subscriber.receive(0.0)
        self.health = None
        command = [sys.executable, "-c", PROGRAM, str(self.folder), json.dumps(self.settings)]
        self.process = subprocess.Popen(command, env=self._environment)

    def kill(self) -> None:
        """Kill the tracker, as the watchdog does."""
        self.process.kill()
        self.process.wait()

    def until(self, wanted: Callable[[ObstacleList], bool]) -> ObstacleList:
        """Play on until a list is as wanted; return it."""
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            self._play()
            for topic, message in self._subscriber.receive(0.02)[0]:
                if topic == "obstacles":
                    self.lists.append(message)
                    if wanted(self.lists[-1]):
                        return self.lists[-1]
                elif topic == "clearance":
                    self.clearances.append(message)
                else:
                    self.health = message
        raise AssertionError((self.lists[-1:], self.health))

    def _play(self) -> None:
        now, k = clock.monotonic_ns(), self._count
        self._count += 1
        if self.poses:
            zeros = (0.0, 0.0, 0.0)
            since_s = max(0, now - self._posed_ns) / clock.NS
            self.ins_turned_rad += self.ins_drift * since_s
            self._north += self.north_mps * since_s
            self._posed_ns = now
            half = 0.5 * (self.heading(now / clock.NS) + self.ins_turned_rad)
            attitude = (math.cos(half), 0.0, 0.0, math.sin(half))
            place = (self.place[0] + self._north, *self.place[1:])
            velocity = (self.north_mps * math.cos(2.0 * half), -self.north_mps * math.sin(2.0 * half), 0.0)
            pose = Pose(k, now + self.ahead_ns, clock.utc_ns(now), place, attitude, velocity, zeros, zeros)
            self._publishers["nav"].publish("pose", pose)
            self.last_pose = k
        if k % 10 == 0:
            for name in self.alive:
                self.report(name)
        if self.pings and k % 3 == 0:
            self.detect(k // 3, now - LISTENING_NS)

    def report(self, name: str) -> None:
        now = clock.monotonic_ns()
        problems = self.problems.get(name, [])
        self._publishers[name].publish("health", Health(name, 1, 0, now, 0, True, problems, {}, {}, {}, {}, 0.0, 0.0))

    def detect(self, number: int, t_ns: int) -> None:
        found = [
            Detection(
                self.range_scale * r,
                b - self.heading(t_ns / clock.NS + 2.0 * r / SOUND),
                1.0,
                5.0,
                3.0,
                14.0,
                20,
                2.0,
                0.05,
                sigma_range_m=0.1,
                sigma_bearing_rad=0.01,
                sigma_radius_m=0.3,
            )
            for r, b in self._seen_from(self._north - self.north_mps * LISTENING_NS / clock.NS)
            if not abs(math.remainder(b - self.heading(t_ns / clock.NS), 2.0 * math.pi)) > SECTOR.bearing_max_rad
        ]
        message = Detections(number, number, t_ns, t_ns + 2 * MS, clock.utc_ns(t_ns), SOUND, SECTOR, found)
        self._publishers["pipeline"].publish("detections", message)

    def _seen_from(self, north: float) -> Echoes:
        seen = [(r * math.cos(b) - north, r * math.sin(b)) for r, b in self.echoes]
        return [(math.hypot(*offset), math.atan2(offset[1], offset[0])) for offset in seen]

    def close(self) -> None:
        self.kill()
        for publisher in self._publishers.values():
            publisher.close()
        self._subscriber.close()
        self._context.term()


@contextmanager
def played(
    settings: Mapping[str, object] | None = None, environment: Mapping[str, str] | None = None
) -> Iterator[Chain]:
    """Yield a chain whose tracker has started."""
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        made = Chain(Path(folder), settings or {}, environment or {})
        try:
            yield made
        finally:
            made.close()


def good(message: ObstacleList) -> bool:
    return message.valid and len(message.obstacles) == 2


def says(text: str) -> Callable[[ObstacleList], bool]:
    return lambda message: not message.valid and any(text in reason for reason in message.reasons)
