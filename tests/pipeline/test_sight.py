"""What a ping could not show: faults are reported at once and where they are, what changes rightly is not."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from ods.base.arrays import Bytes, Floats, Mask
from ods.pipeline.chain import Chain
from ods.pipeline.image.missing.no_data import ALL_DATA
from ods.pipeline.image.samples.recorded import Frame
from ods.pipeline.interference.deaf_beams import DeafBeams
from ods.pipeline.prepared.plan import sample_scale_of
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.sight import BlindnessMonitor, Unseen
from tests.pipeline.pings import fan_bearings, make_ping

BEAMS, SAMPLES, PERIOD_S = 60, 1000, 0.15
RANGE_M = (np.arange(SAMPLES) + 0.5) * 0.1


def bottom_db(depth_m: float) -> Floats:
    """Reverberation over the receiver's noise of 10 dB re 1 count: none before the bottom, then falling."""
    over = np.where(depth_m < RANGE_M, 40.0 - 20.0 * np.log10(np.maximum(RANGE_M, depth_m) / depth_m), -40.0)
    return np.asarray(10.0 * np.log10(10.0 ** (over / 10.0) + 10.0))


def counts(level_db: Floats | float, rng: np.random.Generator) -> Bytes:
    """8-bit logarithmic counts, as record 7042 has them, of speckle of a level."""
    power = np.broadcast_to(10.0 ** (np.asarray(level_db) / 10.0), (BEAMS, SAMPLES))
    amplitude = np.sqrt(power * rng.exponential(size=power.shape))
    return np.rint(40.0 * np.log10(np.maximum(amplitude, 1.0))).astype(np.uint8)


class Sonar:
    """Judges ping after ping of one sonar."""

    def __init__(self) -> None:
        self.sight, self.t_s, self.rng = BlindnessMonitor(), 0.0, np.random.default_rng(2)
        self.period_s = PERIOD_S

    def see(self, frame: Bytes, missing: Mask = ALL_DATA, **changes: Any) -> Unseen:
        self.t_s += self.period_s
        fields = {"scale": "log8", "scale_factor": 40.0, "dr_m": 0.1, "t_ns": round(self.t_s * 1e9)} | changes
        ping = make_ping(frame, **fields)
        all_hear = DeafBeams(np.zeros(ping.beams, np.uint8), False, missing)
        return self.sight.judge(ping, Frame(frame, sample_scale_of(ping), missing, 0), 0, all_hear)

    def watch(self, levels: Iterator[Floats | float], **changes: Any) -> list[Unseen]:
        return [self.see(counts(level, self.rng), **changes) for level in levels]


def steady(level: Floats | float, seconds: float) -> Iterator[Floats | float]:
    return iter([level] * round(seconds / PERIOD_S))


@pytest.mark.parametrize("before", [bottom_db(8.0), bottom_db(3.0), 30.0])
def test_head_that_is_blocked_is_reported_at_its_first_ping_and_healed_at_its_last(before: Floats | float) -> None:
    sonar = Sonar()
    assert not any(seen.share for seen in sonar.watch(steady(before, 5.0)))
    blocked = sonar.watch(steady(np.asarray(before) - 20.0 if np.ndim(before) else 10.0, 20.0))
    assert all(seen.share == 1.0 for seen in blocked)
    assert "head blocked or out of the water" in blocked[0].why
    assert blocked[0].parts[0].why == "level fallen"
    assert not any(seen.share for seen in sonar.watch(steady(before, 5.0)))


def test_half_a_head_is_reported_as_half_the_sector() -> None:
    sonar = Sonar()
    sonar.watch(steady(30.0, 5.0))
    port = np.where(np.arange(BEAMS)[:, None] < BEAMS // 2, 10.0, np.full((1, SAMPLES), 30.0))
    (seen,) = sonar.watch(iter([port]))
    assert seen.share == pytest.approx(0.5, abs=0.07)
    assert max(part.bearing_max_rad for part in seen.parts) == pytest.approx(0.0, abs=0.1)
    assert min(part.bearing_min_rad for part in seen.parts) == pytest.approx(-np.pi / 4, abs=0.02)


LEGITIMATE: dict[str, Sequence[Floats | float]] = {
    "diving from 10 m over the bottom to 60 m at 1 m/s": [
        bottom_db(60.0 - min(k * PERIOD_S, 50.0)) for k in range(400)
    ],
    "rising from 5 m to 60 m over it at 1 m/s": [bottom_db(5.0 + min(k * PERIOD_S, 55.0)) for k in range(400)],
    "a cliff: the bottom falls from 8 to 50 m at once": [bottom_db(8.0)] * 60 + [bottom_db(50.0)] * 200,
    "deep and quiet: nothing but the receiver": [10.0] * 100,
    "into the quiet, 0.5 dB/s": [30.0 - min(0.5 * k * PERIOD_S, 20.0) for k in range(400)],
    "louder by 20 dB within 3 s, a ship": [15.0] * 60 + [15.0 + min(k, 20.0) for k in range(60)],
    "rising from 60 m over the bottom to 5 m at 2 m/s": [bottom_db(60.0 - min(0.3 * k, 55.0)) for k in range(250)],
    "pitching down: the bottom comes into view within 2 s": [10.0] * 60
    + [np.maximum(10.0, bottom_db(6.0) - max(0.0, 30.0 - 2.3 * k)) for k in range(60)],
    "TVG set otherwise: near ranges 20 dB down, far ones up": [30.0] * 60 + [np.asarray(10.0 + 0.4 * RANGE_M)] * 60,
}


@pytest.mark.parametrize("name", LEGITIMATE)
def test_what_changes_rightly_is_no_blindness(name: str) -> None:
    assert [seen.share for seen in Sonar().watch(iter(LEGITIMATE[name]))] == [0.0] * len(LEGITIMATE[name])


@pytest.mark.parametrize(("louder_db", "seconds"), [(30.0, 10.0), (20.0, 30.0), (30.0, 150.0)])
def test_after_a_loud_spell_what_was_before_it_is_no_blindness(louder_db: float, seconds: float) -> None:
    sonar = Sonar()
    sonar.watch(steady(35.0, 5.0))
    sonar.period_s = 0.3
    sonar.watch(steady(35.0 + louder_db, seconds / 2.0))
    assert not any(seen.share for seen in sonar.watch(steady(35.0, 10.0)))
    assert all(seen.share == 1.0 for seen in sonar.watch(steady(15.0, 5.0)))


def test_noise_that_sets_in_hides_what_was_seen_until_the_levels_have_been_so_for_long() -> None:
    sonar = Sonar()
    sonar.watch(steady(35.0, 5.0))
    loud = sonar.watch(steady(55.0, 60.0))
    assert all(seen.share > 0.7 for seen in loud[:2])
    assert all(seen.share == 1.0 for seen in loud[2 : round(15.0 / PERIOD_S)])
    assert loud[0].parts[0].why == "level risen"
    assert "noise 2" in loud[0].why
    assert loud[-1].share == 0.0
    (half,) = sonar.watch(iter([np.where(np.arange(BEAMS)[:, None] < BEAMS // 2, 75.0, np.full((1, SAMPLES), 55.0))]))
    assert half.share == pytest.approx(0.5, abs=0.07)


def test_a_louder_level_is_usual_after_as_long_as_a_lower_one() -> None:
    sonar = Sonar()
    sonar.watch(steady(25.0, 5.0))
    sonar.period_s = 1.0
    sonar.watch(iter([45.0] * 700))
    assert all(seen.share == 1.0 for seen in sonar.watch(iter([25.0] * 10)))


def test_other_gain_or_power_is_no_blindness_and_other_range_hides_none() -> None:
    sonar = Sonar()
    sonar.watch(steady(35.0, 5.0), setting="gain 20 dB")
    assert not any(seen.share for seen in sonar.watch(steady(15.0, 5.0), setting="gain 0 dB"))
    assert not any(seen.share for seen in sonar.watch(steady(15.0, 3.0), setting="gain 0 dB", dr_m=0.05))
    sonar = Sonar()
    sonar.watch(steady(35.0, 5.0))
    assert all(seen.share == 1.0 for seen in sonar.watch(steady(15.0, 3.0)))
    assert all(seen.share == 1.0 for seen in sonar.watch(steady(15.0, 3.0), dr_m=0.05))


def test_a_level_that_stays_low_for_long_becomes_the_level() -> None:
    """Where the sonar does not tell its settings a change of gain is no fault for ever."""
    sonar = Sonar()
    sonar.watch(steady(35.0, 5.0))
    sonar.period_s = 1.0
    shares = [seen.share for seen in sonar.watch(iter([20.0] * 500))]
    assert shares[0] > 0.8  # a fall of 15 dB is no more than what it takes
    assert shares[60] > 0.8
    assert shares[-1] == 0.0


def test_gaps_are_reported_where_they_are() -> None:
    sonar, rng = Sonar(), np.random.default_rng(3)
    for _ in range(30):
        missing = np.zeros((BEAMS, SAMPLES), np.bool_)
        low, high = np.sort(rng.integers(0, BEAMS + 1, 2)).tolist()
        first = int(rng.integers(0, SAMPLES - 100))
        missing[low:high, first:] = True
        seen = sonar.see(counts(30.0, rng), missing)
        reported = np.zeros_like(missing)
        bearings = fan_bearings(BEAMS)
        for part in seen.parts:
            rows = (bearings > part.bearing_min_rad) & (bearings < part.bearing_max_rad)
            columns = (part.range_min_m < RANGE_M - 0.05) & (part.range_max_m > RANGE_M - 0.05)
            reported |= rows[:, None] & columns
            assert part.why == "no data"
        assert (reported != missing).mean() < 1.0 / 64.0
        assert seen.share == pytest.approx(missing.mean(), abs=1.0 / 64.0)


def test_strewn_losses_are_looked_at() -> None:
    rng = np.random.default_rng(3)
    assert Sonar().see(counts(30.0, rng), rng.random((BEAMS, SAMPLES)) < 0.4).share < 0.1


@pytest.mark.parametrize(("value", "why"), [(0, "the sonar sends nothing"), (255, "all samples are alike (255)")])
def test_image_of_one_value_shows_nothing(value: int, why: str) -> None:
    result = Chain(PipelineSettings()).process(make_ping(np.full((BEAMS, SAMPLES), value, np.uint8)))
    assert not result.usable
    assert result.unseen_share == 1.0
    assert why in result.unseen_why
    (part,) = result.unseen
    sector = result.sector
    assert (part.bearing_min_rad, part.bearing_max_rad) == pytest.approx(
        (sector.bearing_min_rad, sector.bearing_max_rad)
    )
    assert (part.range_min_m, part.range_max_m) == pytest.approx((sector.range_min_m, sector.range_max_m))


def test_saturated_parts_are_reported() -> None:
    sonar = Sonar()
    frame = counts(30.0, sonar.rng)
    frame[:, :500] = 255
    seen = sonar.see(frame)
    assert seen.share == pytest.approx(0.5, abs=0.02)
    assert {part.why for part in seen.parts} == {"saturated"}
    assert max(part.range_max_m for part in seen.parts) == pytest.approx(50.0, abs=1.0)


def test_a_tenth_of_the_beams_blocked_is_reported() -> None:
    """Something hangs before the head: 6 of 60 beams, wherever they are."""
    for first in range(0, 55, 9):
        sonar = Sonar()
        sonar.watch(steady(30.0, 5.0))
        level = np.full((BEAMS, 1), 30.0)
        level[first : first + 6] = 12.0
        parts = sonar.watch(steady(level, 1.0))[-1].parts
        assert parts
        assert {part.why for part in parts} == {"level fallen"}
        bearings = fan_bearings(BEAMS)[first : first + 6]
        step = bearings[1] - bearings[0]
        assert min(part.bearing_min_rad for part in parts) >= bearings[0] - step
        assert max(part.bearing_max_rad for part in parts) <= bearings[-1] + step
