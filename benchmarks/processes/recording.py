"""What recording costs: `python -m benchmarks.processes.recording`, a real recorder process on real sockets.

Pings of 120 kB of speckle at 7 a second, 100 poses, 7 detections and lists a second.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import msgspec
import numpy as np
import psutil
import zmq

from ods.base import clock
from ods.messages import Detections, ObstacleList, Ping, Pose, Sector
from ods.runtime import bus

PINGS_HZ, POSES_HZ = 7, 100
BEAMS, SAMPLES = 120, 1000
SETTLE_S = 3.0


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30.0)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        run_dir, out = Path(folder) / "run", Path(folder) / "out"
        run_dir.mkdir()
        config = Path(folder) / "onboard.toml"
        text = Path("config/onboard.toml").read_text()
        config.write_text(text.replace("[bus]", f'[bus]\nrun_dir = "{run_dir}"'))
        command = [sys.executable, "-P", "-m", "ods", "record", "--out", str(out), "--config", str(config)]
        recorder = subprocess.Popen(command)
        try:
            _measure(run_dir, out, recorder, args.seconds)
        finally:
            recorder.terminate()
            recorder.wait()


def _measure(run_dir: Path, out: Path, recorder: "subprocess.Popen[bytes]", seconds: float) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publishers = {name: bus.Publisher(context, run_dir, name) for name in ("sonar", "nav", "pipeline", "tracker")}
    usage = psutil.Process(recorder.pid)
    _play(publishers, SETTLE_S)
    begun, cpu, size = time.monotonic(), _cpu_s(usage), _size(out)
    sent = _play(publishers, seconds)
    spent, cpu, size = time.monotonic() - begun, _cpu_s(usage) - cpu, _size(out) - size
    print("| pings of 120 kB and lists, 1/s | poses, 1/s | share of a core | memory | disk |")
    print("|---|---|---|---|---|")
    rss = usage.memory_info().rss / 1e6
    print(f"| {PINGS_HZ} | {POSES_HZ} | {cpu / spent:.1%} | {rss:.0f} MB | {size / spent * 3.6e-3:.0f} MB/h |")
    print(f"{sent / 1e6 / spent:.2f} MB/s came, {size / 1e6 / spent:.2f} MB/s were written")
    for publisher in publishers.values():
        publisher.close()
    context.term()


def _play(publishers: dict[str, bus.Publisher], seconds: float) -> int:
    """Publish for so long; return the bytes."""
    sent, rng, seq = 0, np.random.default_rng(1), 0
    frames = [np.minimum(rng.rayleigh(20.0, (BEAMS, SAMPLES)), 255.0).astype(np.uint8).tobytes() for _ in range(20)]
    begun = clock.monotonic_ns()
    while (now := clock.monotonic_ns()) - begun < seconds * clock.NS:
        messages: list[tuple[str, str, msgspec.Struct]] = [("nav", "pose", _pose(seq, now))]
        if seq * PINGS_HZ // POSES_HZ != (seq + 1) * PINGS_HZ // POSES_HZ:
            messages += _of_ping(seq, now, frames[seq % len(frames)])
        for process, topic, message in messages:
            publishers[process].publish(topic, message)
            sent += len(msgspec.msgpack.encode(message))
        seq += 1
        time.sleep(max(0.0, (begun + seq * clock.NS // POSES_HZ - clock.monotonic_ns()) / clock.NS))
    return sent


def _pose(seq: int, t_ns: int) -> Pose:
    near, small = (0.01 * seq, 3.3, 5.1), (0.1, 0.2, 0.3)
    return Pose(seq, t_ns, clock.utc_ns(t_ns), near, (1.0, 0.0, 0.0, 0.0), small, small, small)


def _of_ping(seq: int, t_ns: int, data: bytes) -> list[tuple[str, str, msgspec.Struct]]:
    bearings = np.linspace(-0.8, 0.8, BEAMS).tolist()
    stamps = (seq, seq, t_ns, t_ns, clock.utc_ns(t_ns))
    ping = Ping(*stamps, BEAMS, SAMPLES, "u1", data, bearings, 1.0, 0.1, 1500.0)
    sector = Sector(1.0, 100.0, -0.8, 0.8, 0.1)
    found = Detections(*stamps, 1500.0, sector, [])
    picture = ObstacleList(seq, seq, t_ns, t_ns, t_ns, True, [], [])
    return [("sonar", "ping", ping), ("pipeline", "detections", found), ("tracker", "obstacles", picture)]


def _cpu_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _size(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.glob("*.mcap"))


if __name__ == "__main__":
    main()
