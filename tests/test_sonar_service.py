"""The sonar process as a process: a real pseudo-terminal at one end, real ZeroMQ at the other."""

import itertools
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zmq
from sonar_samples import Device, make_ping

from ods import bus, clock
from ods.messages import Health, Ping, frame_of
from ods.sonar_link import s7k

PROGRAM = """
import sys
from pathlib import Path
from types import SimpleNamespace
from ods import service
from ods.processes import PROCESSES
from ods.sonar_link.service import SonarWorker
from ods.sonar_link.settings import SonarSettings

folder = Path(sys.argv[1])
sonar = SonarSettings(port=str(folder / "seabat"), reopen_max_s=0.2, record_timeout_s=0.3)
service.run(SonarWorker, PROCESSES["sonar"], SimpleNamespace(bus=SimpleNamespace(run_dir=folder), sonar=sonar))
"""
PATIENCE_S = 20.0
HOUR_NS = 3_600_000_000_000


class Process:
    """A running sonar process, and what it says."""

    def __init__(self, folder: Path) -> None:
        self.link = folder / "seabat"
        self.pings: list[Ping] = []
        self.health: Health | None = None
        self._process = subprocess.Popen([sys.executable, "-c", PROGRAM, str(folder)])
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._subscriber = bus.Subscriber(self._context, folder, ["ping"], ["sonar"])

    def wait(self, wanted: Callable[[], Any], meanwhile: Callable[[], object] = lambda: None) -> None:
        """Take messages until `wanted` holds."""
        deadline = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < deadline, (self.health, len(self.pings))
            meanwhile()
            for topic, message in self._subscriber.receive(0.05)[0]:
                if topic == "ping":
                    self.pings.append(message)
                else:
                    self.health = message

    def counter(self, name: str) -> int:
        return self.health.counters.get(name, 0) if self.health else 0

    def is_ready(self) -> bool:
        return self.health is not None and self.health.ready

    def problems(self) -> list[str]:
        return self.health.problems if self.health else []

    def says(self, words: str) -> bool:
        return any(words in problem for problem in self.problems())

    def stop(self) -> int:
        self._process.send_signal(signal.SIGTERM)
        return self._process.wait(10)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        self._subscriber.close()
        self._context.term()


@pytest.fixture
def process() -> Iterator[Process]:
    with tempfile.TemporaryDirectory(prefix="ods") as folder:  # its path is short enough for sockets
        running = Process(Path(folder))
        yield running
        running.close()


def send(device: Device, data: bytes) -> None:
    while data:
        data = data[os.write(device.master, data) :]


def test_pings_come_out_and_survive_noise_and_a_pulled_line(process: Process) -> None:
    numbers = itertools.count(1)

    def send_next() -> None:
        send(device, s7k.encode_ping(make_ping(next(numbers))))

    process.wait(lambda: process.says("no such file or directory"))
    assert not process.is_ready()
    assert process.counter("port_open_errors") > 0

    device = Device(process.link)
    process.wait(process.is_ready)
    process.wait(lambda: process.pings, meanwhile=send_next)  # the first ones may find no listener yet

    # the device's clock an hour fast, noise before, a ping cut off behind
    sent = make_ping(500, beams=60, samples=2000, utc_ns=clock.utc_ns() + HOUR_NS)
    send(device, np.random.default_rng(1).bytes(3000) + s7k.encode_ping(sent) + s7k.encode_ping(make_ping(501))[:-1])
    process.wait(lambda: process.pings[-1].ping_number == 500)
    ping = process.pings[-1]
    assert np.array_equal(frame_of(ping), frame_of(sent))
    assert ping.t_ns < ping.t_rx_ns <= clock.monotonic_ns()
    assert abs(ping.utc_ns - clock.utc_ns(ping.t_ns)) < 1_000_000_000
    process.wait(lambda: process.counter("truncated_record") == 1)  # given up after record_timeout_s
    process.wait(lambda: process.says("no ping for "))
    assert process.counter("garbage_bytes") >= 3000

    device.unplug()
    process.wait(lambda: process.says("no such file or directory"))
    device = Device(process.link)
    numbers = itertools.count(502)
    process.wait(lambda: process.counter("port_opens") == 2)
    process.wait(lambda: process.is_ready() and not process.problems(), meanwhile=send_next)
    assert process.pings[-1].ping_number >= 502
    assert process.counter("port_losses") == 1
    assert process.stop() == 0
    device.unplug()
