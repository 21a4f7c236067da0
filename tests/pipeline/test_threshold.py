"""A sonar that tells only what passes a threshold of its own: bodies are found as without it, and speckle is no echo.

The images are numpy's own speckle, and what is below the threshold is known.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import stats

from ods.base.arrays import Floats
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.image.missing.threshold import ThresholdFiller
from ods.pipeline.image.samples.amplitude import sample_scale
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.settings import PipelineSettings
from tests.pipeline.pings import body_echo, fan_bearings, make_ping

SHAPE = BEAMS, SAMPLES = 60, 2000
BEARINGS = fan_bearings(BEAMS)
BODIES = [(20.0, -0.3), (60.0, 0.2), (80.0, 0.5)]
RMS = 10.0


def decibels(amplitude: Floats, least: float) -> Floats:
    return np.asarray(20.0 * np.log10(np.maximum(amplitude, least)))


ENCODED: dict[str, Callable[[Floats], Ping]] = {
    "f4": lambda a: make_ping(a.astype(np.float32)),
    "u1": lambda a: make_ping(np.minimum(a, 255.0).astype(np.uint8)),
    "u2": lambda a: make_ping((100.0 * a).astype(np.uint16)),
    "u1 log8": lambda a: make_ping((2.0 * decibels(a, 1.0)).astype(np.uint8), scale="log8", scale_factor=40.0),
    "u2 db": lambda a: make_ping((100.0 * decibels(a, 1.0)).astype(np.uint16), scale="db", scale_factor=0.01),
    "f4 db": lambda a: make_ping(decibels(a, 1e-3).astype(np.float32), scale="db"),
}


@pytest.mark.parametrize("kind", ENCODED)
@pytest.mark.parametrize(("threshold", "rms"), [(20.0, RMS), (15.0, RMS), (20.0, 0.0), (0.0, 0.0)])
def test_bodies_are_found_and_little_else(kind: str, threshold: float, rms: float) -> None:
    """There were up to 600 false echoes an image, and in floats none at all, without a word."""
    echoes = 100.0**2 * sum(body_echo("half", 1.5, r, b, BEARINGS, SAMPLES) for r, b in BODIES)
    rng, chain, found = np.random.default_rng(4), Chain(PipelineSettings()), 0
    for _ in range(4):
        amplitude = np.sqrt((echoes + rms**2) * rng.exponential(size=SHAPE))
        amplitude[amplitude < threshold] = 0.0
        reported = chain.process(ENCODED[kind](amplitude))
        assert reported.unseen_share == 0.0
        for r, b in BODIES:
            assert any(abs(d.range_m - r) < 2.0 and abs(d.bearing_rad - b) < 0.05 for d in reported.detections)
        found += len(reported.detections)
    assert found <= 4 * len(BODIES) + 4


@pytest.mark.parametrize("rising", [False, True])
def test_what_is_drawn_is_the_speckle_that_was_left_out(rising: bool) -> None:
    """By scipy's Rayleigh distribution, in parts of the range where its level is nearly even."""
    rng = np.random.default_rng(5)
    rms = RMS * (np.linspace(0.7, 1.4, SAMPLES) if rising else np.ones(SAMPLES))
    amplitude = rms * np.sqrt(rng.exponential(size=SHAPE))
    left = np.where(amplitude < 15.0, 0.0, amplitude).astype(np.float32)
    recorded = Recorded(left, np.arange(SAMPLES), 1)
    image = ThresholdFiller().filled(recorded, sample_scale(left.dtype, "linear", 1.0), 7)
    assert (image[left > 0] == left[left > 0]).all()
    for columns in (slice(0, 100), slice(950, 1050), slice(1900, 2000)):
        drawn = (image / rms)[:, columns].ravel()
        assert np.sqrt((drawn**2).mean()) == pytest.approx(1.0, abs=0.06)
        assert stats.kstest(drawn, stats.rayleigh(scale=np.sqrt(0.5)).cdf).statistic < 0.04


def needed(samples: Any, scale: Any = "linear", factor: float = 1.0) -> bool:
    recorded = Recorded(samples, np.arange(samples.shape[1]), 1)
    return ThresholdFiller().is_needed(recorded, sample_scale(samples.dtype, scale, factor))


@pytest.mark.parametrize("rms", [0.2, 0.5, 1.0, 5.0, 50.0])
def test_images_without_a_threshold_are_left_as_they_are(rms: float) -> None:
    amplitude = rms * np.sqrt(np.random.default_rng(6).exponential(size=SHAPE))
    assert not needed(np.minimum(amplitude, 255.0).astype(np.uint8))
    assert not needed(amplitude.astype(np.float32))
    assert not needed((2.0 * decibels(amplitude, 1.0)).astype(np.uint8), "log8", 40.0)


def test_samples_without_data_are_not_below_a_threshold() -> None:
    samples = np.sqrt(np.random.default_rng(6).exponential(size=SHAPE)).astype(np.float32)
    missing = np.random.default_rng(7).random(SHAPE) < 0.6
    samples[missing] = 0.0
    recorded = Recorded(samples, np.arange(SAMPLES), 1, missing)
    assert not ThresholdFiller().is_needed(recorded, sample_scale(samples.dtype, "linear", 1.0))
    nothing = recorded._replace(missing=np.ones(SHAPE, np.bool_))
    assert not ThresholdFiller().is_needed(nothing, sample_scale(samples.dtype, "linear", 1.0))


def test_a_single_echo_in_silence_stays_finite() -> None:
    samples = np.zeros(SHAPE, np.float32)
    samples[30, 1000:1003] = 5.0
    assert needed(samples)
    image = ThresholdFiller().filled(
        Recorded(samples, np.arange(SAMPLES), 1), sample_scale(samples.dtype, "linear", 1.0), 0
    )
    assert np.isfinite(image).all()
    assert image[samples == 0].max() < 5.0
