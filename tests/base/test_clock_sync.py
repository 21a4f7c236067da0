from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.base import clock
from ods.base.clock import NS
from ods.base.clock_sync import CONFIRMATIONS, STEP_CONFIRMATIONS, OffsetEstimator

MS = 1_000_000
PERIOD = 10 * MS
OFFSET = 7_000 * NS


def stream(
    count: int, seed: int, drift_ppm: float = 0.0, least_ns: int = 0, period_ns: int = PERIOD
) -> Iterator[tuple[int, int, int]]:
    """Yield (true instant, device stamp, arrival) of a device whose messages are late by 0 to 8 ms, often by little."""
    delays = np.random.default_rng(seed).exponential(1.0 * MS, count).clip(0, 8 * MS)
    for number in range(count):
        true_ns = 50 * NS + number * period_ns
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


@settings(max_examples=60)
@given(st.integers(0, 2**31), st.one_of(st.integers(-2000, -15), st.integers(15, 2000)))
def test_a_step_longer_than_the_period_never_shows_in_the_mapped_times(seed: int, step_ms: int) -> None:
    """A clock that went back is no delay: the arrival counts until the step is confirmed."""
    estimator = OffsetEstimator()
    for number, (true_ns, device_ns, arrival_ns) in enumerate(stream(400, seed)):
        mapped = estimator.map(device_ns + (number >= 200) * step_ms * MS, arrival_ns)
        if number > 20:
            learning = 200 <= number < 200 + STEP_CONFIRMATIONS + 20
            assert -MS < mapped - true_ns < (9 if learning else 3) * MS
    assert estimator.jumps == (step_ms < 0 or step_ms > 500)  # steps forward are followed at once


@settings(max_examples=60)
@given(st.integers(0, 2**31), st.integers(40, 149))
def test_a_step_back_shorter_than_the_period_is_seen_by_what_it_leaves_behind(seed: int, step_ms: int) -> None:
    estimator = OffsetEstimator()
    for number, (true_ns, device_ns, arrival_ns) in enumerate(stream(400, seed, period_ns=150 * MS)):
        mapped = estimator.map(device_ns - (number >= 200) * step_ms * MS, arrival_ns)
        if number > 20:
            early_ms = step_ms if 200 <= number < 200 + STEP_CONFIRMATIONS else 0
            assert -early_ms - 1 <= (mapped - true_ns) / MS < 4
    assert estimator.jumps == 1


def test_a_step_back_of_the_size_of_delays_is_followed_within_the_window() -> None:
    estimator = OffsetEstimator(window=64)
    for number, (true_ns, device_ns, arrival_ns) in enumerate(stream(400, seed=6)):
        mapped = estimator.map(device_ns - (number >= 200) * 6 * MS, arrival_ns)
        if 20 < number < 200 or number >= 200 + 64 + 1:
            assert abs(mapped - true_ns) < 2 * MS


@settings(max_examples=30)
@given(
    seed=st.integers(0, 2**31),
    stalls_s=st.lists(st.floats(0.02, 4.0), min_size=1, max_size=3),
    load=st.floats(0.0, 0.85),
    fast=st.booleans(),
)
def test_delays_that_shrink_while_a_stalled_line_catches_up_are_no_step(
    seed: int, stalls_s: list[float], load: float, fast: bool
) -> None:
    """The line holds messages back, then passes one in `load` periods; it may stall again before it has caught up."""
    period_ns, jump_ns = (PERIOD, 100 * MS) if fast else (150 * MS, 500 * MS)
    estimator = OffsetEstimator(jump_ns=jump_ns)
    stalls = dict(zip((200, 240, 400), stalls_s, strict=False))
    free_ns = 0
    for number, (true_ns, device_ns, sent_ns) in enumerate(stream(1000, seed, period_ns=period_ns)):
        arrival_ns = max(sent_ns, free_ns) + int(stalls.get(number, 0.0) * NS)
        free_ns = arrival_ns + int(load * period_ns)
        error_ns = estimator.map(device_ns, arrival_ns) - true_ns
        if number > 64 and not fast:  # a fast device fills the window with late messages as its line catches up
            assert abs(error_ns) < 6 * MS  # the envelope may grow by 100 ppm meanwhile
    assert estimator.jumps == 0


@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**31),
    delay_s=st.one_of(st.floats(0.03, 0.5), st.floats(0.5, 30.0)),
    growth=st.one_of(st.just(0.0), st.floats(0.02, 0.5)),
    fast=st.booleans(),
    drift_ppm=st.floats(-90.0, 90.0),
)
def test_a_line_that_goes_on_late_is_no_step(
    seed: int, delay_s: float, growth: float, fast: bool, drift_ppm: float
) -> None:
    """All at once or little by little; its messages are as old as their device says, until they come in time again."""
    period_ns, jump_ns = (PERIOD, 100 * MS) if fast else (150 * MS, 500 * MS)
    estimator = OffsetEstimator(jump_ns=jump_ns)
    last_ns = 0
    for number, (true_ns, device_ns, sent_ns) in enumerate(stream(2000, seed, drift_ppm, period_ns=period_ns)):
        since = number - 200
        late_ns = int(min(delay_s * NS, since * growth * period_ns) if growth else delay_s * NS)
        last_ns = max(last_ns, sent_ns + late_ns * (0 <= since < 1000))
        mapped_error_ns = estimator.map(device_ns, last_ns) - true_ns
        if number > 64:
            drifted_ns = abs(since) * period_ns * 2e-4 if since >= 0 else 0.0
            assert abs(mapped_error_ns) < 12 * MS + min(drifted_ns, delay_s * NS)
        if number > 1600:
            assert abs(mapped_error_ns) < 12 * MS
    assert estimator.jumps == 0


def errors_of(
    line: str, late_s: float = 0.0, step_s: float = 0.0, step_at: int = 400, silence: int = 0, lost: int = 0
) -> tuple[OffsetEstimator, list[tuple[int, float, float]]]:
    """Return (number, error of the mapped time, age by it), s, of each message of a line of some kind.

    The line is late from message 400 to 1200. The clock steps at `step_at`, after so many messages that were not sent;
    `lost`: messages of which the line takes none as it falls behind.
    """
    estimator, found, last_ns = OffsetEstimator(), list[tuple[int, float, float]](), 0
    random = np.random.default_rng(7)
    for number, times_ns in enumerate(stream(1600, 7, period_ns=50 * MS)):
        shift_ns = 25 * MS if line == "two ranges" and number % 2 else 0
        true_ns, device_ns, sent_ns = (t_ns + shift_ns for t_ns in times_ns)
        if step_at - silence <= number < step_at or 400 <= number < 400 + lost:
            continue
        if line == "lossy" and random.random() < 0.05:
            continue
        late_ns = int(late_s * NS) if 400 <= number < 1200 else 0
        if line == "overloaded":
            late_ns = min(late_ns, max(number - 400, 0) * 5 * MS)
        arrival_ns = max(sent_ns + late_ns, last_ns)
        if line == "bursts":
            arrival_ns = -(-arrival_ns // (500 * MS)) * 500 * MS
        last_ns = arrival_ns
        mapped_ns = estimator.map(device_ns + round(step_s * NS) * (number >= step_at), arrival_ns)
        found.append((number, (mapped_ns - true_ns) / NS, (arrival_ns - mapped_ns) / NS))
    return estimator, found


LINES = ["even", "lossy", "bursts", "two ranges"]
OFF_S = {"bursts": 0.12}
"""By so much a line's times may be off, 60 ms if it is not here: the newest of a burst may have waited for its end."""


@pytest.mark.parametrize(
    ("line", "lost"), [*((line, lost) for line in LINES for lost in (0, 1, 5)), ("overloaded", 0), ("overloaded", 1)]
)
def test_a_line_that_falls_behind_by_two_seconds_is_no_step_whatever_it_does_besides(line: str, lost: int) -> None:
    """It loses messages as it falls behind or all the time, sends bursts, or its sonar takes turns between ranges."""
    estimator, found = errors_of(line, late_s=2.0, lost=lost)
    assert max(abs(error_s) for number, error_s, _ in found if number > 64) < OFF_S.get(line, 0.06)
    assert min(age_s for number, _, age_s in found if 500 < number < 1150) > 1.4 - (line == "overloaded")
    assert estimator.jumps == 0


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("step_s", [-2.0, 2.0])
@pytest.mark.parametrize("silence", [0, 30, 60])
def test_a_step_is_followed_within_a_second_whatever_the_line_does(line: str, step_s: float, silence: int) -> None:
    """Also one in a silence, and where many messages come at once."""
    estimator, found = errors_of(line, step_s=step_s, silence=silence)
    assert max(abs(error_s) for number, error_s, _ in found if number > 420) < OFF_S.get(line, 0.06)
    assert max(age_s for number, _, age_s in found if number > 420) < 0.6
    assert estimator.jumps == 1


@pytest.mark.parametrize("line", ["even", "lossy", "two ranges"])
def test_a_clock_set_back_while_the_line_is_late_does_not_make_late_messages_new(line: str) -> None:
    estimator, found = errors_of(line, late_s=2.0, step_s=-3.0, step_at=800)
    assert max(abs(error_s) for number, error_s, _ in found if number > 820) < 0.12
    assert min(age_s for number, _, age_s in found if 410 < number < 1150) > 1.0
    assert estimator.jumps == 1


def test_a_line_with_much_jitter_makes_no_steps() -> None:
    """Half of the delays are longer than what a step must be."""
    estimator = OffsetEstimator()
    delays = np.random.default_rng(9).exponential(15 * MS, 5000)
    for number, (true_ns, device_ns, _) in enumerate(stream(5000, seed=9, period_ns=150 * MS)):
        estimator.map(device_ns, true_ns + int(delays[number]))
    assert estimator.jumps == 0


def test_a_clock_set_back_in_silence_and_reported_by_a_wild_line_is_not_wrong_for_ever() -> None:
    """Neither the device's time went back at any message nor do any agree."""
    estimator = OffsetEstimator(jump_ns=100 * MS)
    delays = np.random.default_rng(8).uniform(0, 80 * MS, 1000)
    for number, (true_ns, device_ns, _) in enumerate(stream(1000, seed=8)):
        silent = 10 * NS if number >= 200 else 0
        stepped = 2 * NS if number >= 200 else 0
        arrival_ns = true_ns + silent + int(delays[number])
        error_ns = estimator.map(device_ns + silent - stepped, arrival_ns) - true_ns - silent
        if number > 900:
            assert abs(error_ns) < 30 * MS


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
