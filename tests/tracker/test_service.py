"""The tracker process as a process: real ZeroMQ on both sides, played by this test."""

import math
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import zmq

from ods.base import clock
from ods.messages import Detection, Detections, Health, ObstacleList, Pose
from ods.runtime import bus
from ods.tracker.map.store import open_map
from tests.tracker.samples import SECTOR

PROGRAM = """
import sys
from pathlib import Path
from ods.runtime import service
from ods.base.geodesy import SiteSettings
from ods.runtime.pose_buffer import PoseSettings
from ods.runtime.processes import PROCESSES
from ods.tracker.service import TrackerWorker
from ods.tracker.settings import MapSettings, PlannerSettings, TrackerConfig, TrackerSettings

folder = Path(sys.argv[1])
tracker = TrackerSettings(map=MapSettings(path=folder / "map.sqlite"), planner=PlannerSettings(period_s=0.1))
site = SiteSettings(latitude_deg=57.0, longitude_deg=10.0)
config = TrackerConfig(site=site, pose=PoseSettings(), tracker=tracker)
service.run_worker(TrackerWorker, PROCESSES["tracker"], folder, config)
"""
PATIENCE_S = 60.0
"""The very first start on a machine compiles."""
MS = 1_000_000
SOUND = 1480.0
LISTENING_NS = 140 * MS
"""Longer than the farthest echo needs."""


class Chain:
    """The other processes, played: poses, detections and health, as long as they are wanted; and the planner."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.lists: list[ObstacleList] = []
        self.health: Health | None = None
        self.alive = {"sonar", "pipeline", "nav"}
        self.problems: dict[str, list[str]] = {}
        self.poses = self.pings = True
        self.echoes = [(40.0, 0.0), (60.0, 0.3)]
        self.heading: Callable[[float], float] = lambda _: 0.0
        """Of the vehicle, rad, at a time in s. `echoes` are seen from heading 0."""
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._publishers = {name: bus.Publisher(self._context, folder, name) for name in ("sonar", "pipeline", "nav")}
        self._subscriber = bus.Subscriber(self._context, folder, ["obstacles"], ["tracker"])
        self._count = 0
        self.start()

    def start(self) -> None:
        self.process = subprocess.Popen([sys.executable, "-c", PROGRAM, str(self.folder)])

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
                else:
                    self.health = message
        raise AssertionError((self.lists[-1:], self.health))

    def _play(self) -> None:
        now, k = clock.monotonic_ns(), self._count
        self._count += 1
        if self.poses:
            zeros = (0.0, 0.0, 0.0)
            half = 0.5 * self.heading(now / clock.NS)
            attitude = (math.cos(half), 0.0, 0.0, math.sin(half))
            pose = Pose(k, now, clock.utc_ns(now), (0.0, 0.0, 4.0), attitude, zeros, zeros, zeros)
            self._publishers["nav"].publish("pose", pose)
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
                r,
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
            for r, b in self.echoes
        ]
        message = Detections(number, number, t_ns, t_ns + 2 * MS, clock.utc_ns(t_ns), SOUND, SECTOR, found)
        self._publishers["pipeline"].publish("detections", message)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        for publisher in self._publishers.values():
            publisher.close()
        self._subscriber.close()
        self._context.term()


@pytest.fixture
def chain() -> Iterator[Chain]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        made = Chain(Path(folder))
        yield made
        made.close()


def good(message: ObstacleList) -> bool:
    return message.valid and len(message.obstacles) == 2


def says(text: str) -> Callable[[ObstacleList], bool]:
    return lambda message: not message.valid and any(text in reason for reason in message.reasons)


def test_pings_make_lists_and_silence_makes_reasons(chain: Chain) -> None:
    message = chain.until(good)
    assert message.ping_number >= 0
    assert message.t_rx_ns == message.t_ns + 2 * MS
    assert {o.state for o in message.obstacles} == {"active"}
    assert message.obstacles[0].position_ned == pytest.approx((40.0, 0.0, 4.0), abs=0.5)
    approach = message.obstacles[0].cpa
    assert approach is not None
    assert approach.distance_m == pytest.approx(40.0 - message.obstacles[0].radius_m, abs=0.5)

    chain.pings = False
    silent = chain.until(says("no ping for 1."))
    assert (silent.ping_number, silent.t_rx_ns) == (-1, 0)
    assert len(silent.obstacles) == 2  # the full picture goes on
    first = chain.until(lambda _: True)
    second = chain.until(lambda _: True)
    assert second.t_ns - first.t_ns < clock.NS  # several a second
    chain.pings = True
    chain.until(good)

    chain.poses = False
    blind = chain.until(says("no pose for 0."))
    assert blind.ping_number >= 0
    assert [o.cpa for o in blind.obstacles] == [None, None]
    chain.until(lambda _: chain.health is not None and "pings_without_reception_pose" in chain.health.counters)
    chain.poses = True
    chain.until(good)

    chain.problems["nav"] = ["the INS is silent"]
    chain.until(says("nav: the INS is silent"))
    chain.problems.clear()
    chain.alive.remove("pipeline")
    chain.until(says("pipeline: no sign of life for 2."))
    assert [later.seq - earlier.seq for earlier, later in zip(chain.lists, chain.lists[1:], strict=False)] == [1] * (
        len(chain.lists) - 1
    )


def test_bearings_are_those_of_the_attitude_at_reception(chain: Chain) -> None:
    """Swinging at up to 20 deg/s; with the attitude at transmission places would be off by 3.1 m and 1 m."""
    chain.echoes = [(95.0, 0.1), (55.0, -0.2)]
    chain.heading = lambda t_s: 0.35 * math.sin(t_s)
    chain.until(good)
    begun = time.monotonic()
    chain.until(lambda _: time.monotonic() > begun + 3.0)
    places = [(r * math.cos(b), r * math.sin(b)) for r, b in chain.echoes]
    for message in filter(good, chain.lists):
        for obstacle in message.obstacles:
            assert min(math.dist(obstacle.position_ned[:2], place) for place in places) < 0.5


def test_bad_detections_are_counted_and_nothing_stops(chain: Chain) -> None:
    chain.until(good)
    now = clock.monotonic_ns()
    chain.detect(1, now - 3600 * clock.NS)
    chain.detect(2, now + 3600 * clock.NS)
    chain.echoes = [(40.0, 0.0), (60.0, 0.3), (float("nan"), 0.0), (-1.0, 0.0)]
    chain.until(lambda _: chain.health is not None and chain.health.counters.get("echoes_bad", 0) > 0)
    assert chain.health is not None
    assert chain.health.counters["detections_late"] >= 1
    assert chain.health.counters["detections_from_future"] == 1
    assert good(chain.until(good))


def test_the_map_outlives_the_process_and_ids_are_not_used_again(chain: Chain) -> None:
    """A clean stop keeps what rests; after kill -9 the map is as it was, and new objects get new ids."""
    ids = {o.id for o in chain.until(lambda m: good(m) and min(o.times_seen for o in m.obstacles) > 30).obstacles}
    chain.process.send_signal(signal.SIGTERM)
    assert chain.process.wait(10) == 0
    store = open_map(chain.folder / "map.sqlite", 57.0, 10.0)
    assert {o.id for o in store.load()} == ids
    store.close()

    chain.echoes.append((50.0, -0.4))
    chain.start()
    back = chain.until(lambda m: m.valid and [o.state for o in m.obstacles] == ["active"] * 3)
    assert {o.id for o in back.obstacles} > ids
    (new,) = {o.id for o in back.obstacles} - ids
    os.kill(chain.process.pid, signal.SIGKILL)
    chain.process.wait()

    chain.start()
    again = chain.until(lambda m: m.valid and [o.state for o in m.obstacles] == ["active"] * 3)
    assert ids < {o.id for o in again.obstacles}
    assert max(o.id for o in again.obstacles) > new
