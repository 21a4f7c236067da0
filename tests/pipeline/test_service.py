"""The pipeline process as a process, pings and detections over real ZeroMQ."""

import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import zmq

from ods.messages import Detections, Health, Ping, Pose
from ods.runtime import bus
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle

PROGRAM = """
import sys
from pathlib import Path
from ods.runtime import service
from ods.pipeline.service import PipelineWorker
from ods.pipeline.settings import PipelineConfig, PipelineSettings
from ods.runtime.processes import PROCESSES
from ods.pose.buffer import PoseSettings

settings = PipelineSettings(stage=tuple({"use": name} for name in sys.argv[2:]))
config = PipelineConfig(pose=PoseSettings(), pipeline=settings)
try:
    service.run_worker(PipelineWorker, PROCESSES["pipeline"], Path(sys.argv[1]), config)
except service.StartError as error:
    sys.exit(str(error))
"""
PATIENCE_S = 60.0
"""Compilation may take this long the first time."""


class Process:
    """A running pipeline process between a sonar and a tracker."""

    def __init__(self, folder: Path, *stages: str) -> None:
        self.found: list[Detections] = []
        self.health: Health | None = None
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self.sonar = bus.Publisher(self._context, folder, "sonar")
        self.nav = bus.Publisher(self._context, folder, "nav")
        self._subscriber = bus.Subscriber(self._context, folder, ["detections"], ["pipeline"])
        self._process = subprocess.Popen([sys.executable, "-c", PROGRAM, str(folder), *stages])

    def wait(self, wanted: Callable[[], Any], ping: Ping | None = None) -> None:
        """Take messages until `wanted` holds, sending `ping` again and again."""
        deadline = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < deadline, (self.health, len(self.found))
            if ping is not None:
                self.sonar.publish("ping", ping)
            self.receive()

    def receive(self) -> None:
        """Take the messages that come within 50 ms."""
        for topic, message in self._subscriber.receive(0.05)[0]:
            if topic == "detections":
                self.found.append(message)
            else:
                self.health = message

    def counter(self, name: str) -> int:
        return self.health.counters.get(name, 0) if self.health else 0

    def stop(self) -> int:
        self._process.send_signal(signal.SIGTERM)
        return self._process.wait(10)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        self.sonar.close()
        self.nav.close()
        self._subscriber.close()
        self._context.term()


@contextmanager
def running(*stages: str) -> Iterator[Process]:
    with tempfile.TemporaryDirectory(prefix="ods") as folder:  # its path is short enough for sockets
        process = Process(Path(folder), *stages)
        try:
            yield process
        finally:
            process.close()


@pytest.fixture
def process() -> Iterator[Process]:
    with running() as process:
        yield process


def test_pings_become_detections_and_bad_ones_are_counted(process: Process) -> None:
    frame = np.random.default_rng(0).rayleigh(20.0, (60, 1000))
    frame[20:24, 500:540] += 200.0
    good = make_ping(np.minimum(frame, 255.0).astype(np.uint8), seq=0)
    process.wait(lambda: process.found, good)  # the first ones may find no listener yet
    assert process.found[0].ping_number == 77
    assert any(abs(d.range_m - 26.0) < 2.0 for d in process.found[0].detections)

    process.wait(lambda: process.counter("bad_ping"), msgspec.structs.replace(good, dr_m=-1.0))
    process.wait(lambda: process.counter("drop_out_image"), make_ping(np.zeros((60, 1000), np.uint8)))
    process.wait(lambda: any(not found.usable for found in process.found))
    assert process.health is not None
    assert process.health.ready
    assert process.counter("process_mean_us") > 0
    assert process.counter("process_max_us") >= process.counter("process_mean_us")
    assert process.counter("detections") > 0

    before = len(process.found)
    process.wait(lambda: len(process.found) > before + 3, good)
    assert process.stop() == 0


def test_a_process_that_learns_from_speckle_is_not_taken_for_hung(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It learns at each other range: for 4 s, of 1024 x 4000 samples, and was killed after 3."""
    reported: list[str] = []
    with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(f"{folder}/notify")
        listener.settimeout(PATIENCE_S)
        monkeypatch.setenv("NOTIFY_SOCKET", f"{folder}/notify")
        with running() as process:
            process.wait(lambda: process.health)
            process.sonar.publish("ping", make_ping(np.random.default_rng(0).integers(0, 255, (60, 1000), np.uint8)))
            deadline = time.monotonic() + PATIENCE_S
            while "WATCHDOG=1" not in reported:  # and no STATUS, as from the work loop
                assert time.monotonic() < deadline, reported
                reported.append(listener.recv(4096).decode())


def test_a_sonar_that_repeats_one_image_under_way_is_not_believed(process: Process) -> None:
    """Pings go on, with numbers and times; the image hangs. A vehicle at rest may see the same twice."""
    image = make_ping(np.random.default_rng(0).rayleigh(20.0, (60, 1000)).astype(np.uint8))
    zero = (0.0, 0.0, 0.0)
    number = 0

    def send(north: float) -> None:
        nonlocal number
        number += 1
        t_ns = number * 100_000_000
        process.nav.publish("pose", Pose(number, t_ns, 0, (north, 0.0, 0.0), (1.0, *zero), zero, zero, zero))
        process.receive()
        process.sonar.publish("ping", msgspec.structs.replace(image, seq=number, ping_number=number, t_ns=t_ns))

    process.wait(lambda: process.found, image)
    for _ in range(20):
        send(0.0)
    process.receive()
    assert process.counter("bad_ping") == 0
    reported = "although the vehicle has moved by 1.5 m and turned by 0 deg: the sonar hangs"
    deadline = time.monotonic() + PATIENCE_S
    while not (process.health and any(reported in problem for problem in process.health.problems)):
        assert time.monotonic() < deadline, process.health
        send(1.5)
    assert process.counter("bad_ping") > 0
    before = len(process.found)
    other = make_ping(np.random.default_rng(1).rayleigh(20.0, (60, 1000)).astype(np.uint8))
    process.wait(lambda: len(process.found) > before, other)
    process.wait(lambda: process.health is not None and not process.health.problems, other)


def test_an_image_that_shows_nothing_is_reported_by_sight_however_often_it_comes(process: Process) -> None:
    zero = (0.0, 0.0, 0.0)
    dark = make_ping(np.zeros((60, 1000), np.uint8))
    for number in range(20):
        seen = len(process.found)
        process.wait(lambda: len(process.found) > seen, dark)  # noqa: B023
        process.nav.publish("pose", Pose(number, number, 0, (2.0 * number, 0.0, 0.0), (1.0, *zero), zero, zero, zero))
    assert process.counter("bad_ping") == 0


def test_decibels_reported_as_amplitudes_are_refused_and_health_says_why(process: Process) -> None:
    """As amplitudes they show nothing; the list would be empty and valid."""
    decibels = 20.0 * np.log10(np.random.default_rng(0).rayleigh(0.01, (60, 1000))).astype(np.float32)
    wrong = make_ping(decibels)
    process.wait(lambda: process.health and any("below 0" in problem for problem in process.health.problems), wrong)
    assert not process.found
    process.wait(lambda: process.found, msgspec.structs.replace(wrong, scale="db", scale_factor=1.0))


@pytest.mark.parametrize("sound_speed", [30.0, 1650.0, 5000.0])
def test_a_sound_speed_that_is_not_waters_is_refused_by_name(process: Process, sound_speed: float) -> None:
    frame = np.random.default_rng(0).rayleigh(20.0, (60, 1000)).astype(np.uint8)
    wrong = make_ping(frame, sound_speed=sound_speed)
    said = f"sound_speed: {sound_speed:g} m/s is not that of water"
    process.wait(lambda: process.health and any(said in problem for problem in process.health.problems), wrong)
    assert not process.found
    process.wait(lambda: process.found, make_ping(frame, sound_speed=1480.0))


def test_filter_over_pings_follows_the_pose() -> None:
    """The vehicle drives at a body, 1 m a ping: only where its own motion is known is it in the same place twice."""
    rng = np.random.default_rng(0)
    zero = (0.0, 0.0, 0.0)
    with running("equalize.mean_range", "filter.fir", "filter.ping_median", "detect.two_level") as process:
        deadline = time.monotonic() + PATIENCE_S
        number = 0
        while not any(found.detections and found.poses_heard for found in process.found):  # the first may come before
            assert time.monotonic() < deadline, (process.health, len(process.found))
            driven = float(number % 25)
            intensity = 1.0 + 200.0 * body_echo("half", 0.4, 45.0 - driven, 0.0, fan_bearings(60), 1000)
            frame = np.minimum(15.0 * speckle(rng, intensity), 255.0).astype(np.uint8)
            t_ns = number * 100_000_000
            process.nav.publish("pose", Pose(number, t_ns, 0, (driven, 0.0, 0.0), (1.0, *zero), zero, zero, zero))
            process.receive()
            process.sonar.publish("ping", make_ping(frame, seq=number, ping_number=number, t_ns=t_ns))
            number += 1
        found = next(found for found in process.found if found.detections and found.poses_heard)
        assert found.detections[0].range_m == pytest.approx(45.0 - found.ping_number % 25, abs=1.0)
        assert found.ping_number <= found.poses_until < number  # each is sent after the pose of its instant


def test_wrong_chain_ends_the_process_with_one_line(tmp_path: Path) -> None:
    with tempfile.TemporaryDirectory(prefix="ods") as folder:
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM, folder, "filter.fir"], capture_output=True, text=True, check=False
        )
    assert done.returncode == 1
    assert done.stderr.startswith("pipeline.stage: exactly the last stage must be one that detects")
    assert done.stderr.count("\n") == 1
