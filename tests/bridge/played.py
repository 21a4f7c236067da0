"""A bridge as a process, with a tracker played, and a receiver: real sockets on all sides."""

import os
import socket
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
from ods.messages import Health, Obstacle
from ods.runtime import bus
from tests.bridge.samples import clearance, image, obstacle_list

ROOT = Path(__file__).parents[2]
PATIENCE_S = 60.0
PERIOD_S = 0.1


class Bridge:
    """The process, and what is published to it while somebody waits."""

    def __init__(self, folder: Path, name: str, table: str) -> None:
        self.process_name = f"bridge_{name}"
        config = folder / "onboard.toml"
        text = (ROOT / "config" / "onboard.toml").read_text().replace("[bus]", f'[bus]\nrun_dir = "{folder}"')
        config.write_text(f"{text}\n[bridge.{name}]\n{table}\n")
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "ods", "bridge", name, "--config", str(config)],
            env=os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
        )
        self.obstacles: list[Obstacle] = []
        self.valid = self.posed = self.published = True
        self.pinged = False
        """Whether images are published, too."""
        self.late_s = 0.0
        """How old lists are when they are published."""
        self.health: Health | None = None
        self._seq = 0
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._tracker = bus.Publisher(self._context, folder, "tracker")
        self._sonar = bus.Publisher(self._context, folder, "sonar")
        self._health = bus.Subscriber(self._context, folder, [], [self.process_name])

    def publish(self) -> None:
        """Publish a list, as it is wanted."""
        now_ns = clock.monotonic_ns()
        if self.published:
            listed = obstacle_list(*self.obstacles, t_ns=now_ns - round(self.late_s * clock.NS))
            reported = msgspec.structs.replace(listed, seq=self._seq, utc_ns=clock.utc_ns(listed.t_ns))
            if not self.valid:
                reported = msgspec.structs.replace(reported, valid=False, reasons=["the INS is silent"])
            if not self.posed:
                reported = msgspec.structs.replace(reported, pose=None)
            self._tracker.publish("obstacles", reported)
            self._tracker.publish("clearance", msgspec.structs.replace(clearance(reported), seq=self._seq))
        if self.pinged:
            self._sonar.publish("ping", image(now_ns))
        self._seq += 1

    def until(self, wanted: Callable[[], bool]) -> None:
        """Publish until `wanted`; fail when that takes too long."""
        deadline_s = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < deadline_s, self.health
            assert self.process.poll() is None
            self.publish()
            for _, message in self._health.receive(PERIOD_S)[0]:
                self.health = message

    def says(self, text: str) -> bool:
        """Tell whether the process says so in its newest health report."""
        return self.health is not None and any(text in problem for problem in self.health.problems)

    def well(self) -> bool:
        """Tell whether it has nothing to say."""
        return self.health is not None and not self.health.problems

    def counts(self, name: str) -> int:
        """Return a counter of its newest health report."""
        return 0 if self.health is None else self.health.counters.get(name, 0)

    def close(self) -> None:
        """End all."""
        self.process.terminate()
        assert self.process.wait(10.0) == 0
        self._tracker.close()
        self._sonar.close()
        self._health.close()
        self._context.term()


@contextmanager
def bridge(name: str, port: int, keys: str = "") -> Iterator[Bridge]:
    """Run a bridge."""
    with bridge_of(name, f'to = "udp://127.0.0.1:{port}"\n{keys}') as made:
        yield made


@contextmanager
def bridge_of(name: str, table: str) -> Iterator[Bridge]:
    """Run a bridge with a table of its own."""
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        made = Bridge(Path(folder), name, table)
        try:
            yield made
        finally:
            made.close()


def receiver(port: int = 0) -> socket.socket:
    """Return a receiver of datagrams that does not wait."""
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.bind(("127.0.0.1", port))
    made.setblocking(False)
    return made


def drained(peer: socket.socket) -> list[bytes]:
    """Return all that has come."""
    found: list[bytes] = []
    while True:
        try:
            found.append(peer.recv(65536))
        except BlockingIOError:
            return found
