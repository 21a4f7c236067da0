"""Pulses that are buried in noise: found at the places of their train, and not beside a body that moves as they do."""

import numpy as np
import pytest

from ods.base.arrays import AnyArray, Floats
from ods.pipeline.interference.buried_pulses import BuriedPulses, PulseTrain
from tests.pipeline.pings import make_ping

PING_S, SOUND_SPEED, DR_M, SAMPLES, BEAMS = 0.1493, 1500.0, 0.05, 2000, 5
PULSE_M = 0.375


def images(arrivals_s: Floats, level: float, seed: int, texture: Floats | None = None) -> BuriedPulses:
    """Return eight pings of noise of 1 count in which a middle beam receives sounds of this level at these times, s."""
    rng, received = np.random.default_rng(seed), BuriedPulses()
    ranges = np.arange(SAMPLES) * DR_M
    for number in range(8):
        sent_s = number * PING_S
        power = np.ones((BEAMS, SAMPLES)) if texture is None else np.tile(texture, (BEAMS, 1))
        for late_s in arrivals_s[(arrivals_s >= sent_s) & (arrivals_s < sent_s + 2.0 * SAMPLES * DR_M / SOUND_SPEED)]:
            near_m = 0.5 * SOUND_SPEED * (late_s - sent_s)
            power[BEAMS // 2, (ranges >= near_m) & (ranges < near_m + PULSE_M)] += level**2
        frame: AnyArray = (100.0 * np.sqrt(rng.exponential(power))).astype(np.uint16)
        received.add(make_ping(frame, t_ns=round(sent_s * 1e9), dr_m=DR_M, sound_speed=SOUND_SPEED), frame, sent_s)
    return received


def line(period_s: float, at_s: float) -> PulseTrain:
    """A train in the middle beam."""
    return PulseTrain(period_s, at_s, 0.0, 0.0, 0.0, 3.0)


@pytest.mark.parametrize(("count", "level"), [(2, 3.0), (3, 2.0), (4, 2.0), (7, 2.0)])
def test_as_many_pulses_are_received_as_there_are_of_which_none_is_an_echo(count: int, level: float) -> None:
    period_s = PING_S * 1.006 / count
    for seed in range(5):
        received = images(0.01 + period_s * np.arange(100, dtype=np.float64), level, seed)
        assert received.a_period(line(period_s * count, 0.01)) == count
        assert received.is_received(line(period_s, 0.01))


@pytest.mark.parametrize("level", [0.0, 3.0, 30.0])
@pytest.mark.parametrize("pings", [1, 2])
def test_a_body_alone_has_no_others_however_loud(level: float, pings: int) -> None:
    """Nor if only each second of its echoes was found, as the others are at places of that train."""
    period_s = PING_S * 0.994
    for seed in range(20):
        received = images(0.07 + period_s * np.arange(20, dtype=np.float64), level, seed)
        assert received.a_period(line(pings * period_s, 0.07)) == 0


def test_bright_places_that_stay_are_no_pulses() -> None:
    for seed in range(20):
        texture = np.random.default_rng(100 + seed).gamma(0.2, 5.0, SAMPLES)
        assert images(np.zeros(0), 0.0, seed, texture).a_period(line(PING_S * 1.006, 0.05)) == 0


def test_images_that_cannot_be_compared_are_left_out() -> None:
    received = images(0.01 + PING_S * 1.006 / 4 * np.arange(100, dtype=np.float64), 2.0, 1)
    frame = np.ones((BEAMS, SAMPLES), np.uint16)
    received.add(make_ping(frame, t_ns=2 * 10**9, dr_m=2.0 * DR_M, sound_speed=SOUND_SPEED), frame, 2.0)
    assert received.a_period(line(PING_S * 1.006, 0.01)) == 0
