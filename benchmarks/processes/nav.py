"""`python -m benchmarks.processes.nav`: what the nav process costs at 100 Hz, and how old its poses are at the tracker.

The real nav process (`ods nav`) reads a simulated INS: on vcan0 where the kernel has it, else from an slcan adapter
on a pseudo-terminal, which costs more. (User-mode Linux is no place for this: its clock ticks every 10 ms.) The frames
of an epoch follow each other as on a bus of 500 kbit/s. The real tracker in a process of its own takes the poses, and
tracks echoes meanwhile.
"""

import argparse
import itertools
import math
import multiprocessing
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import can
import numpy as np
import psutil
import zmq

from ods.base import clock, settings_file
from ods.base.arrays import Ints
from ods.base.geodesy import LocalFrame
from ods.config import OnboardConfig, part_of
from ods.messages import Detection, Detections, Sector
from ods.runtime import bus, service
from ods.runtime.processes import PROCESSES
from ods.sim_sonar.ins.can_bus import can_of
from ods.sim_sonar.ins.canopen_ins import SimulatedIns
from ods.sim_sonar.ins.dbc_ins import SimulatedDbcIns
from ods.sim_sonar.ins.slcan_hub import SlcanHub
from ods.tracker.service import TrackerWorker
from ods.tracker.settings import TrackerProcessConfig

CONFIG = Path(__file__).parents[2] / "config"
FILES = {"canopen": "onboard.toml", "dbc": "onboard-sbg.toml"}
RATE_HZ = 100.0
PERIOD_NS = round(clock.NS / RATE_HZ)
PING_RATE_HZ = 6.7
ECHOES = 10
WARM_UP_S = 3.0
START_S = 120.0
MS = 1_000_000
LONGEST = 20_000
"""Epochs remembered."""


class TimedTracker(TrackerWorker):
    """The tracker, which also notes how old each pose is when it takes it."""

    taken: list[tuple[int, int]]
    """When, and the pose's instant."""

    def start(self) -> None:
        """Start as it does."""
        self.taken = []
        super().start()

    def handle(self, topic: str, message: Any) -> None:
        """Take as it does."""
        if topic == "pose":
            self.taken.append((clock.monotonic_ns(), message.t_ns))
        super().handle(topic, message)

    def stop(self) -> None:
        """Stop as it does."""
        super().stop()
        taken.extend(self.taken)


taken: list[tuple[int, int]] = []


class PacedBus:
    """A bus that takes one frame after the other, as a real one does."""

    def __init__(self, real: can.BusABC, frame_s: float) -> None:
        self._real, self._frame_s = real, frame_s
        self._free_s = 0.0
        self.recv = real.recv

    def send(self, message: can.Message, timeout: float | None = None) -> None:
        """Send when the frame before is over, to some microseconds: a sleep would take too long."""
        while time.monotonic() < self._free_s:
            pass
        self._free_s = max(self._free_s, time.monotonic() - self._frame_s) + self._frame_s
        self._real.send(message, timeout)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--source", choices=FILES, default="canopen")
    parser.add_argument("--frame-ms", type=float, default=0.25, help="of a frame on the bus; 0: all at once")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="ods") as folder, ExitStack() as stack:
        run_dir = Path(folder)
        interface, channel = can_of("auto", run_dir)
        config = _config(args.source, run_dir, interface, channel)
        far = channel
        if interface == "slcan":
            far = str(run_dir / "ins")
            stack.enter_context(SlcanHub([Path(channel), Path(far)]))
        tracker = stack.enter_context(_tracker(config))
        nav = stack.enter_context(_nav(config))
        sent = multiprocessing.get_context("spawn").Array("q", 2 * LONGEST, lock=False)
        stack.enter_context(_process(_send, args.source, interface, far, 1e-3 * args.frame_ms, sent))
        stack.enter_context(_pinging(run_dir))
        time.sleep(WARM_UP_S)
        begun_ns, cpu_percent = clock.monotonic_ns(), _use_of(nav, args.seconds)
        ended_ns = clock.monotonic_ns()
        poses = [(at_ns, t_ns) for at_ns, t_ns in tracker() if begun_ns < at_ns < ended_ns]
        instants, ends = np.array(sent).reshape(2, LONGEST)
    print(f"{args.source} on {interface}: {len(poses)} poses of about {round(args.seconds * RATE_HZ)}")
    print(f"nav: {cpu_percent:.1f} % of a core")
    taken_ns, told_ns = np.array(poses).T
    epoch = np.abs(instants - told_ns[:, None]).argmin(axis=1)
    _show("age of a pose when the tracker has it", taken_ns - told_ns)
    _show("of that until its last frame has left the INS", ends[epoch] - instants[epoch])
    _show("and from then on", taken_ns - ends[epoch])


def _show(what: str, times_ns: Ints) -> None:
    p50, p99 = np.percentile(times_ns / MS, [50, 99])
    print(f"{what}: p50 {p50:.2f} ms, p99 {p99:.2f} ms, longest {times_ns.max() / MS:.1f} ms")


def _config(source: str, run_dir: Path, interface: str, channel: str) -> Path:
    """Write the onboard configuration with this run's folders and bus."""
    text = (CONFIG / FILES[source]).read_text(encoding="utf-8").replace("[bus]", f'[bus]\nrun_dir = "{run_dir}"')
    bitrate = "" if interface == "socketcan" else "\nbitrate = 500000"
    text = text.replace('interface = "socketcan"', f'interface = "{interface}"')
    text = text.replace('channel = "can0"', f'channel = "{channel}"{bitrate}')
    text = text.replace("~/.local/state/ods", str(run_dir))
    for name in ("ins.eds", "ods_node.eds", "sbg.dbc"):
        text = text.replace(f'"{name}"', f'"{CONFIG / name}"')
    config = run_dir / "onboard.toml"
    config.write_text(text, encoding="utf-8")
    return config


@contextmanager
def _nav(config: Path) -> Iterator[psutil.Process]:
    with subprocess.Popen([sys.executable, "-m", "ods", "nav", "--config", str(config)]) as process:
        try:
            yield psutil.Process(process.pid)
        finally:
            process.terminate()


@contextmanager
def _process(job: Callable[..., None], *arguments: Any) -> Iterator[BaseProcess]:
    """Run a function of this module in a process of its own."""
    process = multiprocessing.get_context("spawn").Process(target=job, args=arguments, daemon=True)
    process.start()
    try:
        yield process
    finally:
        process.terminate()
        process.join()


@contextmanager
def _tracker(config: Path) -> Iterator[Callable[[], list[tuple[int, int]]]]:
    """Run the tracker; yield what ends it and returns when it took which pose."""
    here, there = multiprocessing.Pipe(duplex=False)
    with _process(_track, config, there) as process:
        _wait_for_tracker(settings_file.load(config, OnboardConfig).bus.run_dir)

        def finish() -> list[tuple[int, int]]:
            process.terminate()
            found: list[tuple[int, int]] = here.recv()
            return found

        yield finish


def _wait_for_tracker(run_dir: Path) -> None:
    """Wait until it works."""
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    with bus.Subscriber(context, run_dir, [], ["tracker"]) as subscriber:
        deadline_s = time.monotonic() + START_S
        while not subscriber.receive(0.5)[0] and time.monotonic() < deadline_s:
            pass
    context.term()


def _track(config: Path, out: Connection) -> None:
    loaded = settings_file.load(config, OnboardConfig)
    service.run_worker(TimedTracker, PROCESSES["tracker"], loaded.bus.run_dir, part_of(loaded, TrackerProcessConfig))
    out.send(taken)


def _send(source: str, interface: str, channel: str, frame_s: float, sent: Any) -> None:
    """Be the INS, until terminated; note in `sent` the newest instants, ns, and when their last frames had left."""
    options: dict[str, Any] = {"sleep_after_open": 0.0} if interface == "slcan" else {}
    with can.Bus(channel, interface, **options) as real:
        far: Any = PacedBus(real, frame_s)
        ins: SimulatedIns | SimulatedDbcIns
        if source == "canopen":
            ins = SimulatedIns(far, CONFIG / "ins.eds")
        else:
            ins = SimulatedDbcIns(far, CONFIG / "sbg.dbc", LocalFrame(57.0480, 9.9187))
        for number in itertools.count():
            time.sleep((PERIOD_NS - clock.utc_ns() % PERIOD_NS) / clock.NS)
            now_ns, utc_ns = clock.monotonic_ns(), clock.utc_ns()
            ins.send(utc_ns // PERIOD_NS * PERIOD_NS, (0.0, 0.0, 5.0), (1.0, 0.0, 0.0, 0.0), (1.5, 0.0, 0.0))
            sent[number % LONGEST] = now_ns - utc_ns % PERIOD_NS
            sent[LONGEST + number % LONGEST] = clock.monotonic_ns()


@contextmanager
def _pinging(run_dir: Path) -> Iterator[None]:
    """Publish the echoes of one ping after the other, as the pipeline does."""
    stopping = threading.Event()
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, run_dir, "pipeline")
    sector = Sector(1.0, 60.0, -math.pi / 3, math.pi / 3, 0.13)
    echoes = [
        Detection(10.0 + 4.0 * number, -0.8 + 0.15 * number, 0.5, 9.0, 6.0, 20.0, 30, 1.0, 0.05, 0.1, 0.01, 0.1)
        for number in range(ECHOES)
    ]

    def run() -> None:
        for number in itertools.count():
            if stopping.wait(1.0 / PING_RATE_HZ):
                return
            now_ns = clock.monotonic_ns()
            sent_ns = now_ns - 150 * MS
            message = Detections(number, number, sent_ns, now_ns, clock.utc_ns(sent_ns), 1480.0, sector, echoes)
            publisher.publish("detections", message)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stopping.set()
        thread.join()
        publisher.close()
        context.term()


def _use_of(process: psutil.Process, seconds: float) -> float:
    """Return the share of a core that a process takes, %."""
    before, begun_s = process.cpu_times(), time.monotonic()
    time.sleep(seconds)
    after, elapsed_s = process.cpu_times(), time.monotonic() - begun_s
    used_s: float = after.user + after.system - before.user - before.system
    return 100.0 * used_s / elapsed_s


if __name__ == "__main__":
    main()
