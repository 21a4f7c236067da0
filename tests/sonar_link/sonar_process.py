"""A real sonar process to be tested, and the sonar at the far end of its line."""

import contextlib
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import psutil
import pytest
import zmq

from ods.base import clock
from ods.messages import Health, Ping
from ods.runtime import bus
from ods.runtime.raw_bytes import RawBytes
from ods.sonar_link.s7k import records
from tests.sonar_link.sonar_samples import Device, make_ping

PROGRAM = """
import signal, sys, time
from pathlib import Path
from types import SimpleNamespace
from ods.base import clock
from ods.runtime import service
from ods.runtime.processes import PROCESSES
from ods.sonar_link.service import SonarWorker
from ods.sonar_link.settings import SonarConfig, SonarSettings

def step_wall_clock(*_):
    stepped = time.time_ns
    clock.time = SimpleNamespace(time_ns=lambda: stepped() + 100 * clock.NS, monotonic_ns=time.monotonic_ns)

signal.signal(signal.SIGUSR1, step_wall_clock)
folder = Path(sys.argv[1])
sonar = SonarSettings(port=str(folder / "seabat"), publish_raw=True)
service.run_worker(SonarWorker, PROCESSES["sonar"], folder, SonarConfig(sonar=sonar))
"""
PATIENCE_S = 20.0


class Process:
    """A running sonar process, and what it says."""

    def __init__(self, folder: Path) -> None:
        self.link = folder / "seabat"
        self.pings: list[Ping] = []
        self.raw: list[RawBytes] = []
        self.health: Health | None = None
        self._process = subprocess.Popen([sys.executable, "-c", PROGRAM, str(folder)])
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._subscriber = bus.Subscriber(self._context, folder, ["ping", "raw"], ["sonar"])

    def wait(self, wanted: Callable[[], Any], meanwhile: Callable[[], object] = lambda: None) -> float:
        """Take messages until `wanted` holds; return how long that took, s."""
        begun = time.monotonic()
        while not wanted():
            assert time.monotonic() < begun + PATIENCE_S, (self.health, len(self.pings))
            meanwhile()
            self._take(0.05)
        return time.monotonic() - begun

    def listen(self, seconds: float) -> None:
        """Take messages for so long."""
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0.0:
            self._take(left)

    def _take(self, timeout_s: float) -> None:
        for topic, message in self._subscriber.receive(timeout_s)[0]:
            if topic == "ping":
                self.pings.append(message)
            elif topic == "raw":
                self.raw.append(message)
            else:
                self.health = message

    def counter(self, name: str) -> int:
        return self.health.counters.get(name, 0) if self.health else 0

    def dropped_here(self) -> int:
        """Pings that came faster than this subscriber took them."""
        return self._subscriber.subscriptions[0].counters["dropped_ping"]

    def is_ready(self) -> bool:
        return self.health is not None and self.health.ready

    def problems(self) -> list[str]:
        return self.health.problems if self.health else []

    def says(self, words: str) -> bool:
        return any(words in problem for problem in self.problems())

    def hears_again(self) -> None:
        """Take the next health report."""
        seq = self.health.seq if self.health else -1
        self.wait(lambda: self.health is not None and self.health.seq > seq)

    def does_not_spin(self) -> bool:
        """Tell whether the process uses less than a fifth of a core over a second."""
        used, begun = self._cpu_s(), time.monotonic()
        self.listen(1.0)
        return self._cpu_s() - used < 0.2 * (time.monotonic() - begun)

    def _cpu_s(self) -> float:
        times = psutil.Process(self._process.pid).cpu_times()
        return float(times.user + times.system)

    def signal(self, number: signal.Signals) -> None:
        self._process.send_signal(number)

    def stop(self) -> int:
        self.signal(signal.SIGTERM)
        return self._process.wait(10)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        self._subscriber.close()
        self._context.term()


@contextlib.contextmanager
def running() -> Iterator[Process]:
    """Start a sonar process in a folder whose path is short enough for sockets."""
    with tempfile.TemporaryDirectory(prefix="ods") as folder:
        process = Process(Path(folder))
        yield process
        process.close()


class Sonar:
    """The far end: numbers its pings, knows what it sent, and has a clock of its own."""

    def __init__(self, process: Process, device: Device) -> None:
        """Ping until the process is received, so that no later ping is lost for want of a listener."""
        self.device = device
        self.sent: dict[int, Ping] = {}
        """By number; `t_ns` is the true instant of transmission."""
        self.clock_ahead_ns = 3_600_000_000_000
        self.clock_fast_ppm = 0.0
        self._process = process
        self._number = 0
        self._begun_ns = clock.monotonic_ns()
        self._begun_utc_ns = clock.utc_ns(self._begun_ns)
        process.wait(process.is_ready)
        process.wait(lambda: process.pings, meanwhile=lambda: device.send(self.ping()))
        process.wait(self.last_came)
        self._seq = process.pings[-1].seq
        process.pings.clear()
        self.sent.clear()

    def ping(self, **shape: Any) -> bytes:
        """Return the wire form of the next ping, whose last echo has come in just now."""
        self._number += 1
        ping = make_ping(self._number, **shape)
        listened_s = 2.0 * (ping.range0_m + (ping.samples - 1) * ping.dr_m) / ping.sound_speed
        t_ns = clock.monotonic_ns() - round(listened_s * clock.NS)
        run_ns = round((t_ns - self._begun_ns) * (1.0 + 1e-6 * self.clock_fast_ppm))
        device_ns = self._begun_utc_ns + run_ns + self.clock_ahead_ns
        self.sent[self._number] = msgspec.structs.replace(ping, t_ns=t_ns, utc_ns=device_ns)
        return records.encode_ping(self.sent[self._number])

    def play(self, **shape: Any) -> None:
        """Send a ping as a UART does: what the reader's buffer does not take is lost."""
        self.device.offer(self.ping(**shape))

    def play_at(self, rate_hz: float, seconds: float, **shape: Any) -> None:
        """Play pings at a rate, which the reader cannot slow down."""
        begun = time.monotonic()
        for number in range(round(rate_hz * seconds)):
            self.play(**shape)
            time.sleep(max(0.0, begun + (number + 1) / rate_hz - time.monotonic()))

    def last_came(self) -> bool:
        return bool(self._process.pings) and self._process.pings[-1].ping_number == self._number

    def recover(self) -> float:
        """Play until a ping sent from now on comes out whole; return how long that took, s."""
        newest = self._number
        pings = self._process.pings
        return self._process.wait(lambda: pings and pings[-1].ping_number > newest, meanwhile=self.play)

    def check(self) -> None:
        """End with a ping that must come; then all that came must be as sent, in order, and the rest counted."""
        self._process.listen(0.1)
        self.device.send(self.ping())
        self._process.wait(self.last_came)
        self._process.hears_again()
        for ping in self._process.pings:
            assert_same(ping, self.sent[ping.ping_number])
        numbers = [ping.ping_number for ping in self._process.pings]
        assert numbers == sorted(set(numbers))
        published = self._process.pings[-1].seq - self._seq  # what a busy subscriber misses, only `seq` tells
        assert len(self.sent) == published + self._process.counter("lost_pings")


def assert_same(came: Ping, sent: Ping) -> None:
    """The numbers on the wire are float32."""
    assert (came.beams, came.samples, came.scale) == (sent.beams, sent.samples, sent.scale)
    assert came.data == sent.data
    assert came.bearing_rad == sent.bearing_rad
    for name in ("range0_m", "dr_m", "sound_speed", "scale_factor", "frequency_hz"):
        assert getattr(came, name) == pytest.approx(getattr(sent, name), rel=1e-6), name
