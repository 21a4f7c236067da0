"""`python -m benchmarks.nav`: what the nav process costs at 100 Hz x 6 PDOs, and how old its poses are at a reader.

The real process (`ods nav`) reads a simulated INS: on vcan0 where the kernel has it (`vcan/run.py` brings one), else
from an slcan adapter on a pseudo-terminal, which costs more. A subscriber like the tracker's takes the poses.
"""

import argparse
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import can
import numpy as np
import psutil
import zmq

from ods import bus, clock
from ods.messages import Pose
from ods.sim_sonar.can_bus import can_of
from ods.sim_sonar.ins import SimulatedIns
from ods.sim_sonar.slcan_hub import SlcanHub

CONFIG = Path(__file__).parents[1] / "config"
RATE_HZ = 100.0
WARM_UP_S = 3.0
MS = 1_000_000


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30.0)
    seconds = parser.parse_args().seconds
    with tempfile.TemporaryDirectory(prefix="ods") as folder, ExitStack() as stack:
        run_dir = Path(folder)
        interface, channel = can_of("auto", run_dir)
        ins = SimulatedIns(stack.enter_context(_far_end(interface, channel, run_dir)), CONFIG / "ins.eds")
        nav = stack.enter_context(_nav(run_dir, interface, channel))
        stack.enter_context(_sending(ins))
        ages_ms, cpu_percent = _listen(run_dir, nav, seconds)
    wanted = round(seconds * RATE_HZ)
    p50, p99 = np.percentile(ages_ms, [50, 99])
    print(f"{interface}: {len(ages_ms)} poses of about {wanted}, nav {cpu_percent:.1f} % of a core")
    print(f"age of a pose at the reader: p50 {p50:.2f} ms, p99 {p99:.2f} ms, longest {max(ages_ms):.2f} ms")


@contextmanager
def _far_end(interface: str, channel: str, run_dir: Path) -> Iterator[can.BusABC]:
    if interface == "socketcan":
        with can.Bus(channel, interface) as far:
            yield far
        return
    own_end = run_dir / "ins"
    with SlcanHub([Path(channel), own_end]), can.Bus(str(own_end), "slcan", sleep_after_open=0.0) as far:
        yield far


@contextmanager
def _nav(run_dir: Path, interface: str, channel: str) -> Iterator[psutil.Process]:
    text = (CONFIG / "onboard.toml").read_text(encoding="utf-8").replace("/tmp/ods", str(run_dir))
    bitrate = "" if interface == "socketcan" else "\nbitrate = 500000"
    text = text.replace('interface = "socketcan"', f'interface = "{interface}"')
    text = text.replace('channel = "can0"', f'channel = "{channel}"{bitrate}')
    for name in ("ins.eds", "ods_node.eds"):
        text = text.replace(f'"{name}"', f'"{CONFIG / name}"')
    config = run_dir / "onboard.toml"
    config.write_text(text, encoding="utf-8")
    with subprocess.Popen([sys.executable, "-m", "ods", "nav", "--config", str(config)]) as process:
        try:
            yield psutil.Process(process.pid)
        finally:
            process.terminate()


@contextmanager
def _sending(ins: SimulatedIns) -> Iterator[None]:
    stopping = threading.Event()

    def send() -> None:
        due_ns = clock.monotonic_ns()
        while not stopping.wait(max(0.0, (due_ns - clock.monotonic_ns()) / clock.NS)):
            device_ns = clock.utc_ns() // MS * MS
            ins.send(device_ns, (0.0, 0.0, 5.0), (1.0, 0.0, 0.0, 0.0), (1.5, 0.0, 0.0))
            due_ns += round(clock.NS / RATE_HZ)

    sender = threading.Thread(target=send, daemon=True)
    sender.start()
    try:
        yield
    finally:
        stopping.set()
        sender.join()


def _listen(run_dir: Path, nav: psutil.Process, seconds: float) -> tuple[list[float], float]:
    """Return the age of each pose at its arrival here, ms, and the process's share of a core, %."""
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    ages_ms: list[float] = []
    with bus.Subscriber(context, run_dir, ["pose"]) as subscriber:
        _until(subscriber, WARM_UP_S, [])
        before, begun_s = nav.cpu_times(), time.monotonic()
        _until(subscriber, seconds, ages_ms)
        after, elapsed_s = nav.cpu_times(), time.monotonic() - begun_s
    context.term()
    used_s = after.user + after.system - before.user - before.system
    return ages_ms, 100.0 * used_s / elapsed_s


def _until(subscriber: bus.Subscriber, seconds: float, ages_ms: list[float]) -> None:
    stop_s = time.monotonic() + seconds
    while time.monotonic() < stop_s:
        for _, message in subscriber.receive(0.1)[0]:
            if isinstance(message, Pose):
                ages_ms.append((clock.monotonic_ns() - message.t_ns) / MS)


if __name__ == "__main__":
    main()
