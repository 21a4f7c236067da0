"""What readers on other computers cost: `benchmarks.processes.listen`, real processes on real sockets, tcp on loopback.

Lists of 20 obstacles at 20 Hz. When a reader on board and one by tcp have each, by the publisher's clock: first with
one reader by tcp, then with ten more that have stopped reading; and what `ods listen` takes.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
import zmq

from benchmarks.processes.bridges import _list
from ods.base import clock
from ods.runtime import bus
from ods.runtime.keys.key_files import ClientKey, read_client_key
from ods.runtime.keys.key_folder import KeyFolder

LISTS_HZ, STOPPED = 20, 10
SETTLE_S = 3.0
ADDRESS = "tcp://127.0.0.1:56017"
Context = zmq.Context[zmq.Socket[bytes]]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30.0)
    args = parser.parse_args()
    print("| readers by tcp | on board, ms: median | p99 | by tcp, ms: median | p99 | `ods listen`: of a core | MB |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        config = Path(folder) / "onboard.toml"
        listen = f'keys = "keys"\nlisten = [{{at = "{ADDRESS}", topics = ["obstacles"]}}]'
        text = Path("config/onboard.toml").read_text()
        config.write_text(text.replace("[bus]", f'[bus]\nrun_dir = "{folder}"\n{listen}'))
        key = read_client_key(KeyFolder(Path(folder) / "keys").make("planner"))
        command = [sys.executable, "-P", "-m", "ods", "listen", "--config", str(config), "--log-level", "error"]
        process = subprocess.Popen(command, env=os.environ | {"PYTHONPATH": str(Path.cwd())})
        try:
            _run(Path(folder), key, psutil.Process(process.pid), args.seconds)
        finally:
            process.terminate()
            process.wait()


def _run(run_dir: Path, key: ClientKey, usage: psutil.Process, seconds: float) -> None:
    context: Context = zmq.Context()
    tracker = bus.Publisher(context, run_dir, "tracker")
    readers = [_reader(context, bus.endpoint(run_dir, "tracker"), None), _reader(context, ADDRESS, key)]
    _play(tracker, readers, SETTLE_S)
    print(_row("one", tracker, readers, usage, seconds))
    stopped = [_reader(context, ADDRESS, key) for _ in range(STOPPED)]
    _play(tracker, readers, SETTLE_S)
    print(_row(f"and {STOPPED} that read nothing", tracker, readers, usage, seconds))
    for socket in (*readers, *stopped):
        socket.close()
    tracker.close()
    context.term()


def _reader(context: Context, address: str, key: ClientKey | None) -> "zmq.Socket[bytes]":
    socket = context.socket(zmq.SUB)
    socket.setsockopt(zmq.LINGER, 0)
    socket.setsockopt(zmq.RCVHWM, 1)
    if key is not None:
        socket.setsockopt(zmq.CURVE_SERVERKEY, key.server.encode())
        socket.setsockopt(zmq.CURVE_PUBLICKEY, key.own.public.encode())
        socket.setsockopt(zmq.CURVE_SECRETKEY, key.own.secret.encode())
    socket.connect(address)
    socket.setsockopt(zmq.SUBSCRIBE, b"obstacles")
    return socket


def _row(
    name: str, tracker: bus.Publisher, readers: list["zmq.Socket[bytes]"], usage: psutil.Process, seconds: float
) -> str:
    begun, before = time.monotonic(), sum(usage.cpu_times()[:2])
    late_ms = _play(tracker, readers, seconds)
    share = (sum(usage.cpu_times()[:2]) - before) / (time.monotonic() - begun)
    found = [f"{value:.2f}" for each in late_ms for value in np.percentile(each, [50, 99])]
    return f"| {name} | {' | '.join(found)} | {share:.2%} | {usage.memory_info().rss / 1e6:.0f} |"


def _play(tracker: bus.Publisher, readers: list["zmq.Socket[bytes]"], seconds: float) -> list[list[float]]:
    """Publish for so long; return when each reader had each list, ms after it was published."""
    late_ms: list[list[float]] = [[] for _ in readers]
    begun, turn = clock.monotonic_ns(), 0
    while (now := clock.monotonic_ns()) - begun < seconds * clock.NS:
        message = _list(turn, now)
        sent = clock.monotonic_ns()
        tracker.publish("obstacles", message)
        for socket, late in zip(readers, late_ms, strict=True):
            if socket.poll(30):
                socket.recv_multipart()
                late.append((clock.monotonic_ns() - sent) / 1e6)
        turn += 1
        time.sleep(max(0.0, (begun + turn * clock.NS // LISTS_HZ - clock.monotonic_ns()) / clock.NS))
    return late_ms


if __name__ == "__main__":
    main()
