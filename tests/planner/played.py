"""The planner as a process, with a tracker played on real sockets."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import zmq

from ods.base import clock
from ods.messages import Health, Obstacle, PoseAt, VehicleSetPoint
from ods.runtime import bus
from tests.planner.lists import clear, pose, reported

ROOT = Path(__file__).parents[2]
PATIENCE_S = 60.0
PERIOD_S = 0.1


class PlayedPlanner:
    """The process, and what is published to it while somebody waits."""

    def __init__(self, folder: Path, interface: str, channel: str) -> None:
        config = folder / "bench.toml"
        text = (ROOT / "config" / "bench-avoid.toml").read_text().replace("/tmp/ods-bench-avoid", str(folder))
        line = f"interface = '{interface}'\nchannel = '{channel}'\neds = '{ROOT}/config/vehicle.eds'\n"
        config.write_text(text.replace('[planner.can]\neds = "vehicle.eds"\n', f"[planner.can]\n{line}"))
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "ods", "planner", "--config", str(config)],
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )
        self.obstacles: list[Obstacle] = []
        self.valid = self.published = True
        self.here: PoseAt | None = pose(0.0, 0.0)
        self.set_points: list[VehicleSetPoint] = []
        self.health: Health | None = None
        self._seq = 0
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._tracker = bus.Publisher(self._context, folder, "tracker")
        self._subscriber = bus.Subscriber(self._context, folder, ["set-point"], ["planner"])

    def publish(self) -> None:
        """Publish a list and its clearance, as they are wanted."""
        now_ns, self._seq = clock.monotonic_ns(), self._seq + 1
        at = self.here or pose(0.0, 0.0)
        listed = reported(at, *self.obstacles, t_s=now_ns / clock.NS, valid=self.valid)
        water = msgspec.structs.replace(clear(at, valid=self.valid), seq=self._seq, t_ns=now_ns)
        self._tracker.publish("obstacles", msgspec.structs.replace(listed, seq=self._seq, pose=self.here))
        self._tracker.publish("clearance", water)

    def until(self, wanted: Callable[[], bool]) -> None:
        """Publish until `wanted`; fail when that takes too long."""
        deadline_s = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < deadline_s, (self.health, self.set_points[-1:])
            assert self.process.poll() is None
            if self.published:
                self.publish()
            for _, message in self._subscriber.receive(PERIOD_S)[0]:
                if isinstance(message, Health):
                    self.health = message
                else:
                    self.set_points.append(message)

    def newest(self) -> VehicleSetPoint:
        """Return a set point made from now on."""
        begun_ns = clock.monotonic_ns()
        self.until(lambda: bool(self.set_points) and self.set_points[-1].t_ns > begun_ns)
        return self.set_points[-1]

    def says(self, text: str) -> bool:
        """Tell whether its health complains of that."""
        return self.health is not None and any(text in problem for problem in self.health.problems)

    def close(self) -> None:
        """End it."""
        self.process.terminate()
        self.process.wait(20.0)
        self._subscriber.close()
        self._tracker.close()
        self._context.term()


@contextmanager
def played_planner(interface: str, channel: str) -> Iterator[PlayedPlanner]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        running = PlayedPlanner(Path(folder), interface, channel)
        try:
            yield running
        finally:
            running.close()
