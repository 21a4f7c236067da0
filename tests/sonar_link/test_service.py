"""The sonar process as a process: a real pseudo-terminal at one end, real ZeroMQ at the other."""

import itertools
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import msgspec
import numpy as np
import pytest

from ods.base import clock
from ods.messages import frame_of
from ods.runtime.service import Service
from ods.sonar_link.link import SonarLink
from ods.sonar_link.s7k import records
from ods.sonar_link.service import SonarWorker
from ods.sonar_link.settings import SonarConfig, SonarSettings
from tests.sonar_link.sonar_process import Process, running
from tests.sonar_link.sonar_samples import Device, make_ping

HOUR_NS = 3_600_000_000_000


@pytest.fixture
def process() -> Iterator[Process]:
    with running() as process:
        yield process


def test_pings_come_out_and_survive_noise_and_a_pulled_line(process: Process) -> None:
    numbers = itertools.count(1)

    def send_next() -> None:
        device.send(records.encode_ping(make_ping(next(numbers))))

    process.wait(lambda: process.says("no such file or directory"))
    assert not process.is_ready()
    process.wait(lambda: process.counter("port_open_errors") > 0)

    device = Device(process.link)
    process.wait(process.is_ready)
    process.wait(lambda: process.pings, meanwhile=send_next)  # the first ones may find no listener yet

    # the device's clock an hour fast, noise before, a ping cut off behind
    sent = make_ping(500, beams=60, samples=2000, utc_ns=clock.utc_ns() + HOUR_NS)
    device.send(
        np.random.default_rng(1).bytes(3000) + records.encode_ping(sent) + records.encode_ping(make_ping(501))[:-1]
    )
    process.wait(lambda: process.pings[-1].ping_number == 500)
    ping = process.pings[-1]
    assert np.array_equal(frame_of(ping), frame_of(sent))
    assert records.encode_ping(sent) in b"".join(each.data for each in process.raw)  # the bytes of the line, too
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


@pytest.mark.parametrize(("age_s", "reported"), [(0.0, 0), (1.5, 0), (3.2, 1)])
def test_a_sonar_that_pings_seldom_is_not_said_to_be_silent(tmp_path: Path, age_s: float, reported: int) -> None:
    counts = SimpleNamespace(counters=Counter(), publish=lambda *_: None, answer=None, overload=str)
    worker = SonarWorker(cast(Service, counts), SonarConfig(sonar=SonarSettings(port=str(tmp_path / "seabat"))))
    newest_ns = clock.monotonic_ns() - round(age_s * clock.NS)
    for seconds in (3, 2, 1, 0):
        t_ns = newest_ns - seconds * clock.NS
        worker._publish([msgspec.structs.replace(make_ping(9 - seconds), t_ns=t_ns, t_rx_ns=t_ns)])
    assert sum("no ping for" in problem for problem in worker.problems()) == reported


def test_a_port_that_cannot_be_opened_is_not_blamed_on_an_overloaded_computer(tmp_path: Path) -> None:
    service = SimpleNamespace(
        counters=Counter(), publish=lambda *_: None, answer=None, overload=lambda: "the computer is overloaded"
    )
    worker = SonarWorker(cast(Service, service), SonarConfig(sonar=SonarSettings(port=str(tmp_path / "seabat"))))
    worker.tick()
    worker._newest_ns -= 5 * clock.NS
    assert worker.problems() == [f"{tmp_path}/seabat: no such file or directory", "no ping for 5.0 s"]


def test_an_overloaded_computer_does_not_hide_that_records_cannot_be_used(tmp_path: Path) -> None:
    service = SimpleNamespace(
        counters=Counter(), publish=lambda *_: None, answer=None, overload=lambda: "the computer is overloaded"
    )
    worker = SonarWorker(cast(Service, service), SonarConfig(sonar=SonarSettings(port=str(tmp_path / "seabat"))))
    worker._link = cast(SonarLink, SimpleNamespace(fd=0, faults=[]))
    worker._newest_ns -= 5 * clock.NS
    assert worker.problems() == ["no ping for 5.0 s: the computer is overloaded"]
    worker._counters["bad_settings"] += 1
    assert worker.problems() == ["no ping for 5.0 s, though other data arrive: bad_settings"]
