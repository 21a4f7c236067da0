"""What bridges cost: `python -m benchmarks.bridges`, real processes on real sockets, beside a direct subscriber.

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
from pathlib import Path

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
BRIDGES = {"json": "", "ttm": "", "moos": "", "mavlink": "", "mavlink 3d": 'form = "3d"\nmost_m = 200.0'}
"""And further keys. All water but that of 36 sectors is known to be empty."""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    args = parser.parse_args()
    print(f"| bridge | share of a core (wanted: {MOST_SHARE:.0%}) | later, ms: median | p99 ({MOST_MS:g}) | lists |")
    print("|---|---|---|---|---|")
    for name, keys in BRIDGES.items():
        share, late_ms = _measured(name.split()[0], keys, args.seconds)
        median, high = np.percentile(late_ms, [50, 99])
        print(f"| {name} | {share:.2%} | {median:.2f} | {high:.2f} | {len(late_ms)} |")


def _measured(name: str, keys: str, seconds: float) -> tuple[float, list[float]]:
    """Return a bridge's share of a core, and how much later each list was there than at a subscriber, ms."""
    with tempfile.TemporaryDirectory(prefix="ods-") as folder, socket.socket(type=socket.SOCK_DGRAM) as peer:
        peer.bind(("127.0.0.1", 0))
        peer.setblocking(False)
        config = Path(folder) / "onboard.toml"
        text = Path("config/onboard.toml").read_text().replace("[bus]", f'[bus]\nrun_dir = "{folder}"')
        to = f"udp://127.0.0.1:{peer.getsockname()[1]}"
        config.write_text(f'{text}\n[bridge.{name}]\nto = "{to}"\nmost_hz = 100.0\n{keys}\n')
        command = [sys.executable, "-P", "-m", "ods", "bridge", name, "--config", str(config), "--log-level", "error"]
        path = os.pathsep.join([str(Path.cwd()), *sys.path])
        bridge = subprocess.Popen(command, env=os.environ | {"PYTHONPATH": path})
        try:
            return _played(Path(folder), peer, psutil.Process(bridge.pid), seconds)
        finally:
            bridge.terminate()
            bridge.wait()


def _played(run_dir: Path, peer: socket.socket, usage: psutil.Process, seconds: float) -> tuple[float, list[float]]:
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


def _play(tracker: bus.Publisher, direct: bus.Subscriber, peer: socket.socket, seconds: float) -> list[float]:
    late_ms: list[float] = []
    begun, turn = clock.monotonic_ns(), 0
    while (now := clock.monotonic_ns()) - begun < seconds * clock.NS:
        tracker.publish("clearance", _clearance(turn, now))  # first, as it may not delay who looks at the clock
        tracker.publish("obstacles", _list(turn, now))
        late_ms += _late_ms(direct, peer)
        turn += 1
        time.sleep(max(0.0, (begun + turn * clock.NS // LISTS_HZ - clock.monotonic_ns()) / clock.NS))
    return late_ms


def _late_ms(direct: bus.Subscriber, peer: socket.socket) -> list[float]:
    """Return by how much later the first datagram came than the list, ms; nothing where one of them did not come."""
    if not direct.receive(0.1)[0]:
        return []
    there_ns = clock.monotonic_ns()
    with selectors.DefaultSelector() as waiting:
        waiting.register(peer, selectors.EVENT_READ)
        if not waiting.select(0.1):
            return []
        late = (clock.monotonic_ns() - there_ns) / 1e6
        while waiting.select(0.002):  # the others of this list, so that they are not taken for the next one's
            peer.recv(65536)
    return [late]


def _list(turn: int, now_ns: int) -> ObstacleList:
    obstacles = [_obstacle(number, now_ns) for number in range(OBSTACLES)]
    return ObstacleList(
        turn, turn, now_ns, clock.utc_ns(now_ns), now_ns, True, [], obstacles, made_ns=now_ns, pose=POSE
    )


def _clearance(turn: int, now_ns: int) -> Clearance:
    clear_to = [100.0] * 36 + [0.0] * 36
    return Clearance(turn, turn, now_ns, 0, True, [0.0] * 72, clear_to, [None] * 72, POSE, made_ns=now_ns)


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
