"""What bridges cost: `benchmarks.processes.bridges`, real processes on real sockets, beside a direct subscriber.

7 lists of 20 obstacles a second. How much later a receiver has a list than a subscriber to the topic has it,
over all lists, and the share of a core that the bridge takes.
"""

import argparse
import os
import selectors
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import psutil
import zmq

from ods.base import clock
from ods.messages import Clearance, Obstacle, ObstacleList, PoseAt
from ods.runtime import bus

LISTS_HZ, OBSTACLES = 7, 20
SETTLE_S = 3.0
POSE = PoseAt((0.0, 0.0, 5.0), (1.0, 0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.1, 0.1, 0.1), (0.01, 0.01, 0.01))
MOST_SHARE, MOST_MS = 0.02, 5.0
"""What is wanted."""
BRIDGES = {
    "json": "", "ttm": "", "moos": "", "ros2": "", "ros2-four": "", "mavlink": "",
    "mavlink-3d": 'form = "3d"\nmost_m = 200.0',
}  # fmt: skip
"""And further keys; `ros2-four`: a node has subscribed to four topics."""
FOUR = "markers", "clearance", "odometry"
"""Beside the obstacle array."""
ROS_DOMAIN = 99


class Peer(Protocol):
    """A receiver."""

    table: str
    """Keys of the bridge's table, so that it sends to this one."""

    def comes(self, timeout_s: float) -> bool:
        """Tell whether anything is there, or comes within a time."""

    def take(self) -> None:
        """Take one piece of it."""


class UdpPeer:
    """A receiver of datagrams."""

    def __init__(self, listening: socket.socket) -> None:
        self._socket = listening
        self.table = f'to = "udp://127.0.0.1:{listening.getsockname()[1]}"'
        self._waiting = selectors.DefaultSelector()
        self._waiting.register(listening, selectors.EVENT_READ)

    def comes(self, timeout_s: float) -> bool:
        """Tell whether a datagram is there, or comes within a time."""
        return bool(self._waiting.select(timeout_s))

    def take(self) -> None:
        """Take a datagram."""
        self._socket.recv(65536)


class RosPeer:
    """A subscription by DDS, on loopback, to the obstacle array, and to `more` topics whose messages nobody takes."""

    table = f"domain = {ROS_DOMAIN}"

    def __init__(self, more: Sequence[str] = ()) -> None:
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet
        from cyclonedds.domain import Domain, DomainParticipant
        from cyclonedds.qos import Policy, Qos
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic
        from cyclonedds.util import duration

        from ods.bridge.ros2.dds_types import DdsTypes
        from ods.bridge.ros2.interface import configuration
        from ods.bridge.ros2.topics import TOPICS
        from ods.bridge.settings import Ros2Settings
        from ods.ros2.messages import Messages

        types = DdsTypes(Messages().store)
        self._domain = Domain(ROS_DOMAIN, configuration(Ros2Settings(domain=ROS_DOMAIN)))
        participant = DomainParticipant(ROS_DOMAIN)
        qos = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(10))
        readers = []
        for row in (row for key in ("obstacles", *more) for row in TOPICS if row.key == key):
            kind: Any = types.of(row.kind)
            kind.deserialize = classmethod(lambda cls, data, **_: cls(data))  # in C++ what that takes is the node's own
            readers.append(DataReader(participant, Topic(participant, f"rt/ods/{row.name}", kind), qos=qos))
        self._reader, *self._others = readers
        self._waiting = WaitSet(participant)
        self._condition = ReadCondition(self._reader, SampleState.NotRead | ViewState.Any | InstanceState.Alive)
        self._waiting.attach(self._condition)

    def comes(self, timeout_s: float) -> bool:
        """Tell whether a message is there, or comes within a time."""
        return bool(self._waiting.wait(round(timeout_s * clock.NS)))

    def take(self) -> None:
        """Take a message."""
        self._reader.take(1)


@contextmanager
def _peer(row: str) -> Iterator[Peer]:
    if row.startswith("ros2"):
        yield RosPeer(FOUR if row == "ros2-four" else ())
        return
    with socket.socket(type=socket.SOCK_DGRAM) as listening:
        listening.bind(("127.0.0.1", 0))
        listening.setblocking(False)
        yield UdpPeer(listening)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("bridges", nargs="*", default=list(BRIDGES))
    args = parser.parse_args()
    print(f"| bridge | share of a core (wanted: {MOST_SHARE:.0%}) | later, ms: median | p99 ({MOST_MS:g}) | lists |")
    print("|---|---|---|---|---|")
    for name in args.bridges:
        share, late_ms = _measured(name, args.seconds)
        median, high = np.percentile(late_ms, [50, 99])
        print(f"| {name} | {share:.2%} | {median:.2f} | {high:.2f} | {len(late_ms)} |")


def _measured(row: str, seconds: float) -> tuple[float, list[float]]:
    """Return a bridge's share of a core, and how much later each list was there than at a subscriber, ms."""
    name = row.split("-")[0]
    with tempfile.TemporaryDirectory(prefix="ods-") as folder, _peer(row) as peer:
        config = Path(folder) / "onboard.toml"
        text = Path("config/onboard.toml").read_text().replace("[bus]", f'[bus]\nrun_dir = "{folder}"')
        config.write_text(f"{text}\n[bridge.{name}]\n{peer.table}\nmost_hz = 100.0\n{BRIDGES[row]}\n")
        command = [sys.executable, "-P", "-m", "ods", "bridge", name, "--config", str(config), "--log-level", "error"]
        bridge = subprocess.Popen(command, env=os.environ | {"PYTHONPATH": _path()})
        try:
            return _played(Path(folder), peer, psutil.Process(bridge.pid), seconds)
        finally:
            bridge.terminate()
            bridge.wait()


def _played(run_dir: Path, peer: Peer, usage: psutil.Process, seconds: float) -> tuple[float, list[float]]:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    tracker = bus.Publisher(context, run_dir, "tracker")
    with bus.Subscriber(context, run_dir, ["obstacles"]) as direct:
        _play(tracker, direct, peer, SETTLE_S)
        begun, cpu = time.monotonic(), _cpu_s(usage)
        late_ms = _play(tracker, direct, peer, seconds)
        share = (_cpu_s(usage) - cpu) / (time.monotonic() - begun)
    tracker.close()
    context.term()
    return share, late_ms


def _play(tracker: bus.Publisher, direct: bus.Subscriber, peer: Peer, seconds: float) -> list[float]:
    late_ms: list[float] = []
    begun, turn = clock.monotonic_ns(), 0
    while (now := clock.monotonic_ns()) - begun < seconds * clock.NS:
        tracker.publish("obstacles", _list(turn, now))
        tracker.publish("clearance", _water(turn, now))
        late_ms += _late_ms(direct, peer)
        turn += 1
        time.sleep(max(0.0, (begun + turn * clock.NS // LISTS_HZ - clock.monotonic_ns()) / clock.NS))
    return late_ms


def _late_ms(direct: bus.Subscriber, peer: Peer) -> list[float]:
    """Return by how much later the first datagram came than the list, ms; nothing where one of them did not come."""
    if not direct.receive(0.1)[0]:
        return []
    there_ns = clock.monotonic_ns()
    if not peer.comes(0.1):
        return []
    late = (clock.monotonic_ns() - there_ns) / 1e6
    while peer.comes(0.002):  # the others of this list, so that they are not taken for the next one's
        peer.take()
    return [late]


def _list(turn: int, now_ns: int) -> ObstacleList:
    obstacles = [_obstacle(number, now_ns) for number in range(OBSTACLES)]
    return ObstacleList(
        turn, turn, now_ns, clock.utc_ns(now_ns), now_ns, True, [], obstacles, made_ns=now_ns, pose=POSE
    )


def _water(turn: int, now_ns: int) -> Clearance:
    count = 72
    return Clearance(
        turn, turn, now_ns, clock.utc_ns(now_ns), True, [1.0] * count, [30.0] * count, [None] * count, POSE,
        made_ns=now_ns,
    )  # fmt: skip


def _path() -> str:
    return os.pathsep.join(filter(None, [str(Path.cwd()), os.environ.get("PYTHONPATH", "")]))


def _obstacle(number: int, now_ns: int) -> Obstacle:
    return Obstacle(
        id=number + 1,
        state="active",
        position_ned=(30.0 + number, 7.123 * number, 5.0),
        velocity_ned=(0.1, 0.2, 0.0),
        radius_m=1.5,
        sigma_position=(0.3, 0.3, 3.0),
        sigma_velocity=(0.1, 0.1, 0.1),
        sigma_radius=0.2,
        first_seen_utc_ns=now_ns,
        last_seen_utc_ns=now_ns,
        times_seen=9,
        existence=0.99,
    )


def _cpu_s(usage: psutil.Process) -> float:
    times = usage.cpu_times()
    return float(times.user + times.system)


if __name__ == "__main__":
    main()
