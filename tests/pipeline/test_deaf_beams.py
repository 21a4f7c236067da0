"""Beams that say nothing: they are reported, and nothing else suffers."""

import numpy as np
import pytest

from ods.base.arrays import Bytes, Floats
from ods.messages import Detections
from ods.pipeline.chain import Chain
from ods.pipeline.image.missing.no_data import ALL_DATA
from ods.pipeline.image.samples.recorded import Frame
from ods.pipeline.interference.deaf_beams import BeamJudge
from ods.pipeline.prepared.plan import sample_scale_of
from ods.pipeline.settings import PipelineSettings
from tests.pipeline.pings import fan_bearings, make_ping

BEAMS, SAMPLES, PERIOD_S = 60, 2000, 0.15
QUIET_DB, BOTTOM_DB, FROM = 28.0, 44.0, 400
SPOKE = 40
LINEAR = {"scale": "linear", "scale_factor": 1.0}


def scene_db() -> Floats:
    """The receiver's noise, and a bottom from a fifth of the range on."""
    level = np.full((BEAMS, SAMPLES), QUIET_DB)
    level[:, FROM:] = BOTTOM_DB
    return level


def add(level_db: Floats, more_db: Floats | float) -> Floats:
    return np.asarray(10.0 * np.log10(10.0 ** (level_db / 10.0) + 10.0 ** (np.asarray(more_db) / 10.0)))


class Sonar:
    """Judges ping after ping of 8-bit logarithmic counts."""

    def __init__(self) -> None:
        self.judge, self.rng, self.number = BeamJudge(), np.random.default_rng(5), 0

    def counts(self, level_db: Floats) -> Bytes:
        amplitude = np.sqrt(10.0 ** (level_db / 10.0) * self.rng.exponential(size=level_db.shape))
        return np.rint(40.0 * np.log10(np.maximum(amplitude, 1.0))).clip(0, 255).astype(np.uint8)

    def codes(self, frame: Bytes, planes: int = 1) -> list[int]:
        self.number += 1
        beams = len(frame) // planes
        ping = make_ping(
            frame, scale="log8", scale_factor=40.0, t_ns=round(self.number * PERIOD_S * 1e9), planes=planes,
            bearing_rad=fan_bearings(beams).tolist() * planes,
        )  # fmt: skip
        codes: list[int] = self.judge.judge(ping, Frame(frame, sample_scale_of(ping), ALL_DATA, 0), 0).codes.tolist()
        return codes

    def see(self, level_db: Floats) -> list[int]:
        return self.codes(self.counts(level_db))


def test_beams_at_full_scale_are_saturated_and_no_others() -> None:
    sonar = Sonar()
    frame = sonar.counts(scene_db())
    frame[::7] = 255
    assert sonar.codes(frame) == [2 if beam % 7 == 0 else 0 for beam in range(BEAMS)]
    assert not any(sonar.see(scene_db()))


def test_a_body_or_a_wall_at_full_scale_is_no_saturated_beam() -> None:
    sonar = Sonar()
    frame = sonar.counts(scene_db())
    frame[20:30, 900:1700] = 255
    assert not any(sonar.codes(frame))


@pytest.mark.parametrize("level_db", [56.0, 66.0])
def test_a_source_without_end_is_reported_at_the_first_ping_with_what_its_side_lobes_fill(level_db: float) -> None:
    level = scene_db()
    for beam, down_db in ((SPOKE, 0.0), (SPOKE + 1, 22.0), (SPOKE - 1, 22.0)):
        level[beam] = add(level[beam], level_db - down_db)
    sonar = Sonar()
    for _ in range(20):
        codes = sonar.see(level)
        assert codes[SPOKE - 1 : SPOKE + 2] == [4, 4, 4]
        assert not any(codes[: SPOKE - 2] + codes[SPOKE + 3 :])


def test_a_source_that_begins_in_open_water_is_reported_at_once_and_until_it_ends() -> None:
    sonar, quiet = Sonar(), np.full((BEAMS, SAMPLES), QUIET_DB)
    for _ in range(30):
        assert not any(sonar.see(quiet))
    loud = quiet.copy()
    loud[SPOKE] = add(loud[SPOKE], QUIET_DB + 10.0)
    assert [sonar.see(loud)[SPOKE] for _ in range(200)] == [4] * 200
    assert not any(sonar.see(quiet))


def test_a_beam_of_another_gain_hears_for_all_that() -> None:
    sonar, level = Sonar(), scene_db()
    level += np.random.default_rng(1).uniform(-10.0, 10.0, (BEAMS, 1))
    assert not any(any(sonar.see(level)) for _ in range(50))


def test_loud_scenes_are_no_source() -> None:
    """A body near by, one all along the quiet ranges, and half a fan that sees the bottom as the vehicle rolls."""
    sonar = Sonar()
    for _ in range(20):
        assert not any(sonar.see(scene_db()))
    level = scene_db()
    level[30:33, 100:FROM] = 70.0
    assert not any(sonar.see(level))
    level = scene_db()
    level[:25, 20:] = 55.0
    assert not any(any(sonar.see(level)) for _ in range(5))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_side_of_the_fan_that_a_roll_raises_over_all_ranges_is_no_source_and_hides_none(side: float) -> None:
    sonar = Sonar()
    for _ in range(20):
        assert not any(sonar.see(scene_db()))
    rolled = scene_db() + side * np.linspace(-11.0, 11.0, BEAMS)[:, None]
    assert not any(any(sonar.see(rolled)) for _ in range(5))
    rolled[SPOKE] += 30.0
    assert sonar.see(rolled)[SPOKE] == 4


def test_planes_are_judged_by_themselves() -> None:
    sonar = Sonar()
    frame = np.vstack([sonar.counts(scene_db()), sonar.counts(scene_db() + 20.0)])
    assert not any(sonar.codes(frame, planes=2))
    frame[7] = 255
    assert [beam for beam, code in enumerate(sonar.codes(frame, planes=2)) if code] == [7]


def found_beside(spoil: slice | None, level: float = 255.0) -> Detections:
    """The detections of two bodies of 20 dB over speckle; the beams `spoil` are noise of a mean level."""
    rng = np.random.default_rng(3)
    frame = np.sqrt(30.0**2 * rng.exponential(size=(BEAMS, SAMPLES)))
    for beam, first in ((15, 800), (36, 1200)):
        frame[beam : beam + 4, first : first + 30] *= 10.0
    if spoil is not None:
        frame[spoil] = level * 1.128 * np.sqrt(rng.exponential(size=frame[spoil].shape))
    return Chain(PipelineSettings()).process(make_ping(frame.clip(0, 255).astype(np.uint8)))


@pytest.mark.parametrize("level", [255.0, 1e6])
@pytest.mark.parametrize("spoil", [slice(41, 50), slice(45, 57), slice(0, 12)])
def test_bodies_beside_beams_at_full_scale_are_found_as_ever(spoil: slice, level: float) -> None:
    alone, beside = found_beside(None), found_beside(spoil, level)
    assert len(alone.detections) == 2
    for one, other in zip(alone.detections, beside.detections, strict=True):
        assert (other.range_m, other.bearing_rad) == pytest.approx((one.range_m, one.bearing_rad), abs=0.3)
    assert {part.why for part in beside.unseen} == {"saturated"}
    assert beside.unseen_share == pytest.approx((spoil.stop - spoil.start) / BEAMS)


def test_all_beams_at_full_scale_show_nothing_and_break_nothing() -> None:
    for planes in (1, 2):
        frame = np.random.default_rng(0).integers(250, 260, (BEAMS, SAMPLES)).clip(0, 255).astype(np.uint8)
        ping = make_ping(frame, planes=planes, bearing_rad=fan_bearings(BEAMS // planes).tolist() * planes)
        found = Chain(PipelineSettings()).process(ping)
        assert (found.detections, found.unseen_share) == ([], 1.0)
