"""Another sonar's pulses: reported by their period from bodies, still, moving and flickering."""

import math
from collections.abc import Iterable

import numpy as np
import pytest

from ods.messages import Detection, Ping
from ods.pipeline.interference.pulses import PulseFinder, Pulses
from ods.pipeline.measure.echoes import NO_ECHOES
from tests.pipeline.pings import echo_table, make_ping

PERIOD_S, RANGE_M, SOUND_SPEED = 0.1493, 100.0, 1500.0
FRAME = np.ones((2, 2000), np.uint8)
RNG = np.random.default_rng(7)


def echo(range_m: float, bearing_deg: float = 12.0) -> Detection:
    """A small echo, measured with errors."""
    near_m = range_m + RNG.normal(0.0, 0.07)
    bearing = math.radians(bearing_deg + RNG.normal(0.0, 0.4))
    return Detection(
        near_m + 0.3, bearing, 0.3, 10.0, 5.0, 20.0, 30, 0.6, math.radians(3.0), 0.1, 0.01, 0.1, near_m=near_m
    )


def ping_at(t_s: float) -> Ping:
    return make_ping(FRAME, t_ns=round(t_s * 1e9))


def pulses_at(t_s: float, period_s: float, bearing_deg: float = 12.0) -> list[Detection]:
    """What a train of pulses leaves in the image of a ping."""
    first = math.ceil(t_s / period_s)
    ranges = [0.5 * SOUND_SPEED * (k * period_s - t_s) for k in range(first, first + 20)]
    return [echo(r, bearing_deg) for r in ranges if 1.0 < r < RANGE_M]


def watch(pings: Iterable[tuple[float, list[Detection]]]) -> list[Pulses]:
    finder = PulseFinder()
    return [finder.classify(ping_at(t_s), FRAME, echo_table(echoes), NO_ECHOES) for t_s, echoes in pings]


@pytest.mark.parametrize("period_s", [0.0371, 0.06, 0.1, 0.11])
def test_pulses_are_reported_within_a_second_and_bodies_beside_them_stay(period_s: float) -> None:
    pings = []
    for number in range(60):
        t_s = number * PERIOD_S
        bodies = [echo(60.0 - t_s), echo(35.0 - 0.3 * t_s, -8.0)]
        pings.append((t_s, [*bodies, *pulses_at(t_s, period_s)]))
    for (t_s, echoes), reported in list(zip(pings, watch(pings), strict=True)):
        assert not reported.of_echoes[1]
        if t_s > 1.0:
            assert sum(reported.of_echoes[2:]) >= len(echoes) - 3
            assert (reported.why != "") == bool(reported.of_echoes.any())
            assert len(reported.parts) == sum(reported.of_echoes)
    assert f"{1e3 * period_s:.1f} ms" in reported.why or not reported.why


def test_two_trains_are_two_trains() -> None:
    times = [number * PERIOD_S for number in range(40)]
    pings = [(t_s, [*pulses_at(t_s, 0.0371), *pulses_at(t_s, 0.1, -20.0)]) for t_s in times]
    reported = watch(pings)
    assert all(all(pulses.of_echoes) for pulses in reported[12:])
    assert "37.1 ms" in reported[-1].why
    assert "100.0 ms" in reported[-1].why


@pytest.mark.parametrize("speed_mps", [0.0, -1.0, 3.0, -8.0, 12.0])
def test_a_body_is_no_train_however_it_moves(speed_mps: float) -> None:
    times = [number * PERIOD_S for number in range(60)]
    pings = [(t_s, [echo(r)] if 1.0 < (r := 50.0 + speed_mps * (t_s - 4.0)) < RANGE_M else []) for t_s in times]
    assert not any(reported.why for reported in watch(pings))


def test_bodies_that_flicker_are_no_train() -> None:
    """Weak echoes come and go, in fragments, and some only in the rings that have their turn."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        places = rng.uniform(5.0, 95.0, 12)
        pings = []
        for number in range(80):
            t_s = number * PERIOD_S
            seen = rng.random(12) < 0.3
            seen[:3] = number % 4 == np.arange(3)
            ranges = places[seen] - 1.5 * t_s
            pings.append((t_s, [echo(r) for r in [*ranges, *(ranges[:2] + 0.5)] if 1.0 < r < RANGE_M]))
        assert not any(reported.why for reported in watch(pings))


def test_pulses_at_nearly_our_own_period_are_reported_once_that_changes() -> None:
    """Once a ping and on a line is what a body does; with another range set, and so another period, it is not."""
    times = np.cumsum([PERIOD_S] * 60 + [0.125] * 30).tolist()
    reported = watch([(t_s, pulses_at(t_s, 0.149)) for t_s in times])
    assert not any(pulses.why for pulses in reported[:60])
    assert all(pulses.why or not pulses.of_echoes.size for pulses in reported[70:])


def test_a_pause_and_a_clock_that_goes_back_begin_anew() -> None:
    times = [number * PERIOD_S for number in range(20)]
    reported = watch([(t_s, pulses_at(t_s, 0.1)) for t_s in [*times, *times, *(t_s + 100.0 for t_s in times)]])
    for begin in (0, 20, 40):
        assert not reported[begin].why
        assert reported[begin + 18].why
