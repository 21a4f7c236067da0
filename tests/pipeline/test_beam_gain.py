"""Beams of different gain: no echoes of nothing, and what is no gain stays."""

import numpy as np
import pytest

from ods.base.arrays import Floats, Image
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.settings import PipelineSettings
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle
from tests.pipeline.steps import stage_on_images

BEAMS, SAMPLES = 60, 2000
FAN = Fan(fan_bearings(BEAMS), np.full(BEAMS, 0.026), SAMPLES, 0.0, 0.05)


def one_beam(gain_db: float) -> Floats:
    return np.where(np.arange(BEAMS) == 30, gain_db, 0.0)


def drawn(seed: int) -> Floats:
    return np.random.default_rng(seed).uniform(-20.0, 20.0, BEAMS)


def rayleigh(seed: int) -> Image:
    return np.random.default_rng(seed).rayleigh(1.0, (BEAMS, SAMPLES)).astype(np.float32)


@pytest.mark.parametrize("gain_db", [one_beam(-20.0), one_beam(6.0), one_beam(20.0), drawn(1), drawn(2)])
@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_default_chain_finds_nothing_in_speckle_of_beams_of_different_gain(gain_db: Floats, dtype: str) -> None:
    """At most 0.3 an image; a beam 6 dB up gave 50, one of 20 dB up, saturated in 8 bits, a circle of 50 m radius."""
    mean, top = (30.0, 255.0) if dtype == "uint8" else (3000.0, 65535.0)
    rng, chain, found = np.random.default_rng(3), Chain(PipelineSettings()), 0
    for number in range(18):  # so many that gains are measured again
        amplitude = mean * 10.0 ** (gain_db[:, None] / 20.0) * speckle(rng, np.ones((BEAMS, SAMPLES)))
        found += len(chain.process(make_ping(np.minimum(amplitude, top).astype(dtype), seq=number)).detections)
    assert found <= 5


def test_objects_in_loud_and_dark_beams_are_found() -> None:
    places = [(r, float(b)) for r in (20.0, 45.0, 70.0) for b in (-0.5, -0.2, 0.25, 0.6)]
    intensity = 1.0 + sum(60.0 * body_echo("half", 1.0, r, b, fan_bearings(BEAMS), SAMPLES) for r, b in places)
    amplitude = 300.0 * 10.0 ** (drawn(4)[:, None] / 20.0) * speckle(np.random.default_rng(5), np.asarray(intensity))
    found = Chain(PipelineSettings()).process(make_ping(np.minimum(amplitude, 65535.0).astype(np.uint16))).detections
    for range_m, bearing in places:
        assert any(np.hypot(d.range_m - range_m, range_m * (d.bearing_rad - bearing)) < 2.5 for d in found)


def test_shadow_behind_a_wall_is_no_gain() -> None:
    image = rayleigh(6)
    image[20:35, 180:200] *= 20.0
    image[20:35, 200:] *= 0.05
    np.testing.assert_allclose(stage_on_images("equalize.beam_gain", FAN)(image), image, rtol=0.25)  # 2 of 26 dB


def test_gains_are_followed() -> None:
    run, loud = stage_on_images("equalize.beam_gain", FAN), rayleigh(7)
    loud[12] *= 5.0
    levels = [run(rayleigh(7))[12].mean(), *(run(loud)[12].mean() for _ in range(20))]
    assert levels[0] == pytest.approx(rayleigh(7)[12].mean(), rel=0.05)
    assert levels[-1] == pytest.approx(levels[0], rel=0.05)
