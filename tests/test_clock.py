from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ods import clock
from ods.clock import CONFIRMATIONS, NS, OffsetEstimator

MS = 1_000_000
PERIOD = 10 * MS
OFFSET = 7_000 * NS


def stream(count: int, seed: int, drift_ppm: float = 0.0, least_ns: int = 0) -> Iterator[tuple[int, int, int]]:
    """Yield (true instant, device stamp, arrival) of a device whose messages are late by 0 to 8 ms, often by little."""
    delays = np.random.default_rng(seed).exponential(1.0 * MS, count).clip(0, 8 * MS)
    for number in range(count):
        true_ns = 50 * NS + number * PERIOD
        device_ns = round((true_ns - 50 * NS) * (1.0 + drift_ppm * 1e-6)) + OFFSET
        yield true_ns, device_ns, true_ns + least_ns + int(delays[number])


@settings(max_examples=20)
@given(seed=st.integers(0, 2**31), drift_ppm=st.floats(-90.0, 90.0))
def test_offset_is_found_within_the_smallest_delays_and_follows_drift(seed: int, drift_ppm: float) -> None:
    estimator = OffsetEstimator()
    for number, (true_ns, device_ns, arrival_ns) in enumerate(stream(3000, seed, drift_ppm)):
        mapped = estimator.map(device_ns, arrival_ns)
        assert mapped <= arrival_ns
        if number > 64:
            assert -MS < mapped - true_ns < 1.5 * MS
    assert estimator.jumps == 0


@pytest.mark.parametrize("error_ns", [-300 * MS, 300 * MS, -100 * NS, 100 * NS])
def test_one_bad_stamp_changes_nothing_for_the_others(error_ns: int) -> None:
    clean, disturbed = OffsetEstimator(), OffsetEstimator()
    for number, (_, device_ns, arrival_ns) in enumerate(stream(400, seed=1)):
        bad = number == 200
        expected = clean.map(device_ns, arrival_ns)
        mapped = disturbed.map(device_ns + bad * error_ns, arrival_ns)
        assert mapped <= arrival_ns
        if not bad:
            assert abs(mapped - expected) < MS // 2
    assert disturbed.jumps == 0
    assert disturbed.wild == (abs(error_ns) > 500 * MS)


@pytest.mark.parametrize("error_ns", [-100 * NS, 100 * NS])
def test_a_bad_first_stamp_is_lived_down(error_ns: int) -> None:
    estimator = OffsetEstimator()
    for number, (true_ns, device_ns, arrival_ns) in enumerate(stream(100, seed=2)):
        mapped = estimator.map(device_ns + (number == 0) * error_ns, arrival_ns)
        assert mapped <= arrival_ns
        if number > 10:
            assert abs(mapped - true_ns) < 2 * MS


@pytest.mark.parametrize("jump_ns", [-100 * NS, 100 * NS, NS])
def test_a_jump_of_the_device_clock_is_believed_when_confirmed(jump_ns: int) -> None:
    estimator = OffsetEstimator()
    for number, (true_ns, device_ns, arrival_ns) in enumerate(stream(400, seed=3)):
        jumped = number >= 200
        mapped = estimator.map(device_ns + jumped * jump_ns, arrival_ns)
        if number > 10:  # not yet confirmed, the arrival counts; then the envelope is learned anew
            learning = 200 <= number < 200 + CONFIRMATIONS + 6
            assert abs(mapped - true_ns) < (9 if learning else 2) * MS
        assert estimator.jumps == 0 or jumped
    assert estimator.jumps == 1


@pytest.mark.parametrize("step_ns", [-200 * MS, 200 * MS])
def test_a_step_too_small_to_be_a_jump_is_followed_within_the_window(step_ns: int) -> None:
    estimator = OffsetEstimator(window=64)
    for number, (true_ns, device_ns, arrival_ns) in enumerate(stream(400, seed=6)):
        mapped = estimator.map(device_ns + (number >= 200) * step_ns, arrival_ns)
        if 20 < number < 200 or number >= 200 + 64 + 1:
            assert abs(mapped - true_ns) < 2 * MS
    assert estimator.jumps == 0


def test_a_backlog_read_in_one_go_is_no_jump() -> None:
    estimator = OffsetEstimator()
    stalled_until = 0
    for number, (true_ns, device_ns, arrival_ns) in enumerate(stream(600, seed=4)):
        if number == 200:
            stalled_until = arrival_ns + 2 * NS
        mapped = estimator.map(device_ns, max(arrival_ns, stalled_until + number * 20_000))
        if number > 64:
            assert abs(mapped - true_ns) < 2 * MS
    assert estimator.jumps == 0


def test_utc_of_a_monotonic_instant(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clock, "time", SimpleNamespace(time_ns=lambda: 1_700_000_000 * NS, monotonic_ns=lambda: 5 * NS))
    assert clock.utc_ns() == 1_700_000_000 * NS
    assert clock.utc_ns(3 * NS) == 1_699_999_998 * NS
