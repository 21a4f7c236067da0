"""Clocks that step, jump, drift and come late: the poses' instants hold, and the event is counted."""

import struct
from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest

from ods.base import clock, clock_sync
from ods.base.clock import NS
from ods.messages import Pose
from ods.nav_bridge.can.stamp_clock import StampClock
from ods.nav_bridge.clocks.utc import WallClock
from tests.nav_bridge.canopen_samples import DAY_MS, IDS, MS, PERIOD, UTC_OFFSET, Bench, pdos

NOON_MS = 43_200_000
EPOCHS = 1_000


def pose_of(bench: Bench, number: int, device_ms: int, late_ns: int = 0) -> Pose | None:
    """Feed epoch `number`; return its pose."""
    pose = None
    for place, data in enumerate(pdos(number, ms=device_ms % DAY_MS)):
        pose = bench.take(IDS[place], data, number * PERIOD + late_ns + place * 250_000) or pose
    return pose


def off_by(bench: Bench, number: int, device_ms: int, late_ns: int = 0) -> int | None:
    """Feed epoch `number`; return the error of the pose's instant, ns, None when there is no pose."""
    pose = pose_of(bench, number, device_ms, late_ns)
    return None if pose is None else pose.t_ns - number * PERIOD


class Clocks:
    """Both clocks of a machine, set by hand."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.mono_ns, self.ahead_ns = 0, UTC_OFFSET
        fake = SimpleNamespace(time_ns=lambda: self.mono_ns + self.ahead_ns, monotonic_ns=lambda: self.mono_ns)
        monkeypatch.setattr(clock, "time", fake)

    def stamp_ns(self, t_ns: int) -> int:
        """Return how the kernel stamps a frame at `t_ns`."""
        return t_ns + self.ahead_ns


@pytest.mark.parametrize("step_s", [-100, 100])
def test_a_step_of_the_wall_clock(monkeypatch: pytest.MonkeyPatch, step_s: int) -> None:
    """The kernel stamps with the wall clock; frames are read 0.3 ms later; one of them has the step between."""
    bench, clocks = Bench(), Clocks(monkeypatch)
    stamps = StampClock(bench.counters)
    errors = []
    for number in range(1, EPOCHS):
        for place, data in enumerate(pdos(number)):
            arrived_ns = number * PERIOD + place * 250_000
            stamp_ns = clocks.stamp_ns(arrived_ns)
            clocks.mono_ns = arrived_ns + 300_000
            if (number, place) == (500, 0):
                clocks.ahead_ns += step_s * NS
            pose = bench.take(IDS[place], data, stamps.arrival_ns(stamp_ns))
            if pose is not None:
                errors.append(pose.t_ns - number * PERIOD)
            stamps.emptied()
    assert len(errors) == EPOCHS - 1
    assert max(np.abs(errors)) < MS
    assert bench.counters["wall_clock_steps"] == 1
    assert bench.counters["ins_clock_jumps"] == 0


@pytest.mark.parametrize("step_s", [-100, -2, 0, 2, 100])
def test_frames_that_waited_a_second_for_their_reader_keep_their_arrival(
    monkeypatch: pytest.MonkeyPatch, step_s: int
) -> None:
    """The process was stopped, and the wall clock stepped half-way."""
    clocks = Clocks(monkeypatch)
    stamps = StampClock(Counter())
    clocks.mono_ns = 5 * NS
    stamps.emptied()
    queue = []
    for arrived_ns in range(5 * NS + MS, 6 * NS, 10 * MS):
        if arrived_ns > 5.5 * NS and clocks.ahead_ns == UTC_OFFSET:
            clocks.ahead_ns += step_s * NS
        queue.append((arrived_ns, clocks.stamp_ns(arrived_ns)))
    clocks.mono_ns = 6 * NS
    assert [stamps.arrival_ns(stamp_ns) for _, stamp_ns in queue] == [arrived_ns for arrived_ns, _ in queue]


def test_a_stamp_of_another_clock_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    clocks = Clocks(monkeypatch)
    stamps = StampClock(Counter())
    clocks.mono_ns = NS
    assert [stamps.arrival_ns(stamp_ns) for stamp_ns in (0, clocks.stamp_ns(2 * NS))] == [NS, NS]


@pytest.mark.parametrize("jump_ms", [-3_600_000, -1_000, 1_000, 100_000, 40_000_000])
def test_a_jump_of_the_ins_clock(jump_ms: int) -> None:
    bench = Bench()
    random = np.random.default_rng(1)
    found = [
        off_by(bench, number, NOON_MS + 10 * number + (number >= 500) * jump_ms, int(random.exponential(0.3 * MS)))
        for number in range(1, EPOCHS)
    ]
    errors = [error for error in found if error is not None]
    assert len(errors) >= EPOCHS - 1 - clock_sync.CONFIRMATIONS
    assert max(np.abs(errors)) < 4 * MS
    assert bench.counters["ins_clock_jumps"] == 1


@pytest.mark.parametrize("late_ms", [300, 2_000])
def test_a_line_that_falls_behind_makes_no_jump_of_the_ins_clock(late_ms: int) -> None:
    """Poses are of their instants, or none and it is said, for as long as it lasts; then all is well at once."""
    bench = Bench()
    random = np.random.default_rng(1)
    found, said = [], list[str]()
    for number in range(1, 2 * EPOCHS):
        late_ns = MS * late_ms * (500 <= number < 1_500) + int(random.exponential(0.3 * MS))
        found.append(off_by(bench, number, NOON_MS + 10 * number, late_ns))
        if number == 1_499:
            said = bench.source.problems(number * PERIOD + late_ns)
    assert max(abs(error) for error in found if error is not None) < 4 * MS
    assert (found[499:1_499] == [None] * 1_000) == (late_ms == 2_000)
    assert None not in [*found[:499], *found[1_499:]]
    assert any("2.0 s late by the INS's clock" in text for text in said) == (late_ms == 2_000)
    assert bench.counters["ins_clock_jumps"] == 0


@pytest.mark.parametrize("silence", [0, 300])
def test_a_clock_set_back_behind_an_adapter_that_sends_bursts(silence: int) -> None:
    """Ten epochs at once; in a silence as well there are poses again within a second, as old as they are."""
    bench = Bench()
    found = [
        (number, off_by(bench, number, NOON_MS + 10 * number - 2_000 * (number >= 500), (-number % 10) * PERIOD))
        for number in range(1, EPOCHS)
        if not 500 - silence <= number < 500
    ]
    assert None not in [error for number, error in found if number >= 520]
    assert max(abs(error) for number, error in found if number >= 520 and error is not None) < 15 * MS
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
    bench.wall_clock = WallClock(0, synchronized=False)
    errors, reported = [], {}
    for number in range(1, 6_000):
        t_ns = number * PERIOD
        if number % 100 == 0:
            late_ns = 3 * NS if number in (2_000, 2_300) else 0
            ahead_ns = 20 * NS if number >= 4_000 else 0
            bench.take(0x100, time_message(t_ns + UTC_OFFSET - late_ns + ahead_ns), t_ns)
        pose = pose_of(bench, number, NOON_MS + 10 * number)
        assert pose is not None
        errors.append(pose.t_ns - number * PERIOD)
        reported[number] = pose.utc_ns - pose.t_ns
    assert max(np.abs(errors)) < MS
    assert bench.counters["time"] == 59
    assert all(abs(reported[number] - UTC_OFFSET) < MS for number in range(100, 4_000))
    assert abs(reported[4_500] - UTC_OFFSET - 20 * NS) < MS
    assert bench.counters["time_wild"] == 2 + clock_sync.CONFIRMATIONS
    assert bench.counters["time_jumps"] == 1
    assert bench.counters["ins_clock_jumps"] == 0
