"""Clocks that step, jump, drift and come late: the poses' instants hold, and the event is counted."""

import struct
from types import SimpleNamespace

import numpy as np
import pytest
from canopen_samples import DAY_MS, IDS, MS, PERIOD, UTC_OFFSET, Bench, pdos

from ods import clock
from ods.clock import NS
from ods.nav_bridge.wall_clock import WallClock

NOON_MS = 43_200_000
EPOCHS = 1_000


def off_by(bench: Bench, number: int, device_ms: int, late_ns: int = 0) -> int | None:
    """Feed epoch `number`; return the error of the pose's instant, ns, None when there is no pose."""
    pose = None
    for place, data in enumerate(pdos(number, ms=device_ms % DAY_MS)):
        pose = bench.take(IDS[place], data, number * PERIOD + late_ns + place * 250_000) or pose
    return None if pose is None else pose.t_ns - number * PERIOD


@pytest.mark.parametrize("step_s", [-100, 100])
def test_a_step_of_the_wall_clock(monkeypatch: pytest.MonkeyPatch, step_s: int) -> None:
    """The kernel stamps with the wall clock; frames are read 0.3 ms later; one of them has the step between."""
    bench = Bench()
    watch = WallClock(bench.counters)
    now = SimpleNamespace(mono=0, ahead=UTC_OFFSET)
    fake = SimpleNamespace(time_ns=lambda: now.mono + now.ahead, monotonic_ns=lambda: now.mono)
    monkeypatch.setattr(clock, "time", fake)
    errors = []
    for number in range(1, EPOCHS):
        for place, data in enumerate(pdos(number)):
            arrived_ns = number * PERIOD + place * 250_000
            stamp_s = (arrived_ns + now.ahead) / NS
            now.mono = arrived_ns + 300_000
            if (number, place) == (500, 0):
                now.ahead += step_s * NS
            pose = bench.take(IDS[place], data, clock.arrival_ns(stamp_s))
            if pose is not None:
                errors.append(pose.t_ns - number * PERIOD)
            watch.watch(now.mono, clock.utc_ns(now.mono))
    assert len(errors) == EPOCHS - 1
    assert sorted(np.abs(errors))[-2] < MS
    assert max(np.abs(errors)) <= clock.MAX_STAMP_AGE_NS  # the frame that was on its way
    assert bench.counters["wall_clock_steps"] == 1
    assert bench.counters["ins_clock_jumps"] == 0


@pytest.mark.parametrize("jump_ms", [-3_600_000, -1_000, 1_000, 100_000, 40_000_000])
def test_a_jump_of_the_ins_clock(jump_ms: int) -> None:
    bench = Bench()
    random = np.random.default_rng(1)
    found = [
        off_by(bench, number, NOON_MS + 10 * number + (number >= 500) * jump_ms, int(random.exponential(0.3 * MS)))
        for number in range(1, EPOCHS)
    ]
    errors = [error for error in found if error is not None]
    assert len(errors) >= EPOCHS - 1 - clock.CONFIRMATIONS
    assert max(np.abs(errors)) < 4 * MS
    assert bench.counters["ins_clock_jumps"] == 1


@pytest.mark.parametrize("drift_ppm", [-80.0, 80.0])
def test_a_drifting_ins_clock(drift_ppm: float) -> None:
    bench = Bench()
    random = np.random.default_rng(2)
    errors = [
        off_by(bench, number, NOON_MS + int(10 * number * (1.0 + 1e-6 * drift_ppm)), int(random.exponential(0.5 * MS)))
        for number in range(1, 20_000)  # 200 s: 16 ms of drift
    ]
    assert None not in errors
    assert max(np.abs([error or 0 for error in errors])) < 4 * MS
    assert bench.counters["ins_clock_jumps"] == bench.counters["ins_clock_wild"] == 0


def time_message(utc_ns: int) -> bytes:
    days, ms = divmod(utc_ns // MS - 441_763_200_000, DAY_MS)  # CiA 301 counts from 1984-01-01
    return struct.pack("<IH", ms, days)


def test_time_messages_that_come_late_or_jump() -> None:
    bench = Bench(heartbeat_timeout_s=0.0)
    errors, said = [], {}
    for number in range(1, 6_000):
        t_ns = number * PERIOD
        if number % 100 == 0:
            late_ns = 3 * NS if number in (2_000, 2_300) else 0
            ahead_ns = 20 * NS if number >= 4_000 else 0
            bench.take(0x100, time_message(t_ns + UTC_OFFSET - late_ns + ahead_ns), t_ns)
        errors.append(off_by(bench, number, NOON_MS + 10 * number))
        said[number] = [text for text in bench.source.problems(t_ns) if "UTC" in text]
    assert None not in errors
    assert max(np.abs([error or 0 for error in errors])) < MS
    assert bench.counters["time"] == 59
    assert not any(said[number] for number in range(1, 4_000))
    assert said[4_500] == ["UTC of the INS is +20.0 s from this machine's"]
    assert bench.counters["time_wild"] == 2 + clock.CONFIRMATIONS
    assert bench.counters["time_jumps"] == 1
    assert bench.counters["ins_clock_jumps"] == 0
