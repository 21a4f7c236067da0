"""A chain to record: real sockets, simulated pings, a vehicle and an obstacle that are where they are reported."""

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import numpy as np
import zmq

from ods.base.frames.geometry import quat_from_euler
from ods.messages import Obstacle, ObstacleList, Ping, Pose, TrackState
from ods.runtime import bus
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import load_scene

ROOT = Path(__file__).parents[2]
START_NS = 1_700_000_000_250_000_000
PERIOD_NS = 150_000_000
LATITUDE_DEG, LONGITUDE_DEG = 57.0480, 9.9187
ROLL, PITCH, HEADING = 0.05, -0.1, 1.25
VEHICLE_NED = (120.0, -40.0, 15.0)


def simulated_pings(count: int, linear16: bool) -> list[Ping]:
    """Return the first pings of a scene by the SeaBat 6012: record 7042's samples, or with `linear16` record 7018's."""
    scene = load_scene(ROOT / "config" / "scenes" / "figure11.toml")
    images = ImageSimulator(find_sonar("seabat6012"), scene, 7)
    pings = [images.ping(n * 0.15, n, START_NS + n * PERIOD_NS, START_NS + n * PERIOD_NS) for n in range(count)]
    return [as_linear16(ping) for ping in pings] if linear16 else pings


def as_linear16(ping: Ping) -> Ping:
    """Return the ping as a sonar of linear 16-bit samples sends it, from range 0."""
    counts = np.frombuffer(ping.data, np.uint8).astype(np.float64)
    linear = np.round(10.0 ** (counts / ping.scale_factor)).clip(0, 65535).astype("<u2")
    return msgspec.structs.replace(
        ping, data=linear.tobytes(), dtype="u2", scale="linear", scale_factor=1.0, range0_m=0.0
    )


def pose_at(t_ns: int, seq: int = 0) -> Pose:
    """Return the pose of a vehicle at rest; its UTC is its `t_ns`, which starts at START_NS."""
    w, x, y, z = quat_from_euler(ROLL, PITCH, HEADING).tolist()
    return Pose(seq, t_ns, t_ns, VEHICLE_NED, (w, x, y, z), (0.0,) * 3, (0.1,) * 3, (0.01,) * 3)


def rock(seen_ns: int, state: TrackState = "active", number: int = 7) -> Obstacle:
    """Return an obstacle 30 m ahead of the vehicle's heading and 40 m to its starboard, at its depth."""
    north = VEHICLE_NED[0] + 30.0 * math.cos(HEADING) - 40.0 * math.sin(HEADING)
    east = VEHICLE_NED[1] + 30.0 * math.sin(HEADING) + 40.0 * math.cos(HEADING)
    return Obstacle(
        id=number, state=state, position_ned=(north, east, VEHICLE_NED[2]), velocity_ned=(0.0, 0.0, 0.0),
        radius_m=1.5, sigma_position=(0.2, 0.3, 3.0), sigma_velocity=(0.0, 0.0, 0.0), sigma_radius=0.1,
        first_seen_utc_ns=START_NS, last_seen_utc_ns=seen_ns, times_seen=9, existence=0.97,
    )  # fmt: skip


def obstacles_at(t_ns: int, seq: int, *obstacles: Obstacle) -> ObstacleList:
    return ObstacleList(seq, seq, t_ns, t_ns, t_ns, True, [], list(obstacles))


class Chain:
    """The publishers of a chain on a run folder of its own."""

    def __init__(self, folder: Path, *processes: str) -> None:
        self.run_dir = folder
        self.config = folder / "onboard.toml"
        text = (ROOT / "config" / "onboard.toml").read_text()
        self.config.write_text(text.replace("[bus]", f'[bus]\nrun_dir = "{folder}"'))
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._publishers = {name: bus.Publisher(self._context, folder, name) for name in processes}

    def publish(self, message: Ping | ObstacleList | Pose) -> None:
        topic = {Ping: "ping", ObstacleList: "obstacles", Pose: "pose"}[type(message)]
        self._publishers[bus.TOPICS[topic].publisher].publish(topic, message)

    def record(self, *arguments: str, prelude: str = "") -> "subprocess.Popen[str]":
        """Start `ods record`; `prelude` is Python that runs in it first."""
        program = f"{prelude}\nimport sys\nfrom ods.cli import main\nsys.exit(main(sys.argv[1:]))"
        return subprocess.Popen(
            [sys.executable, "-c", program, "record", *arguments, "--config", str(self.config)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT, env=dict(os.environ),
        )  # fmt: skip

    def publish_until_recorded(self, path: Path, message: Ping | ObstacleList | Pose) -> None:
        """Publish a message until the file grows by it: from then on its topic is received."""
        wait_for(lambda: size_of(path) > 0)
        before = settled_size_of(path)
        for _ in range(400):
            self.publish(message)
            time.sleep(0.05)
            if size_of(path) > before:
                return
        raise AssertionError("the recorder does not receive the chain")

    def close(self) -> None:
        for publisher in self._publishers.values():
            publisher.close()
        self._context.term()


@contextmanager
def chain(*processes: str) -> Iterator[Chain]:
    """Run publishers of the processes named in a folder whose path is short enough for sockets."""
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        running = Chain(Path(folder), *processes)
        try:
            yield running
        finally:
            running.close()


def size_of(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def settled_size_of(path: Path) -> int:
    """Return the file's size once it grows no more: what was published before has been written."""
    size, before = size_of(path), -1
    while size != before:
        time.sleep(0.25)
        size, before = size_of(path), size
    return size


def wait_for(condition: Callable[[], bool]) -> None:
    for _ in range(400):
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("it did not come true")
