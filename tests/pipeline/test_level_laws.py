"""The laws of benchmarks.level_methods: the levels that they fit, against quantiles of the clutter itself."""

import numpy as np
import pytest
from numpy.random import Generator

from benchmarks.level_methods.laws import GammaLaw, KLaw, Law, ParetoLaw
from ods.base.arrays import Floats32
from ods.pipeline.detect.noise import NoiseMeter

SHAPE = 64, 4096
LEVEL = 3.0
MEDIAN, UPPER = np.sqrt(-np.log([0.5, 1.0 - 0.8413]))
SHARE = float(np.exp(-((MEDIAN + LEVEL * (UPPER - MEDIAN)) ** 2)))
"""Of Rayleigh speckle above the level."""


def speckle(rng: Generator, order: float = np.inf) -> Floats32:
    texture = rng.gamma(order, 1.0 / order, SHAPE) if np.isfinite(order) else 1.0
    return np.asarray(np.sqrt(rng.exponential(size=SHAPE) * texture), np.float32)


@pytest.mark.parametrize("law", [KLaw, GammaLaw, ParetoLaw])
@pytest.mark.parametrize("order", [np.inf, 5.0, 1.0, 0.5])
def test_fitted_level_is_reached_as_seldom_as_by_speckle(law: type[Law], order: float) -> None:
    rng, meter, fitted = np.random.default_rng(3), NoiseMeter(), law(SHAPE)
    fitted.learn(speckle(rng) for _ in range(4))
    image = speckle(rng, order)
    background, noise = meter.background_and_noise(image)
    judged = fitted.levelled(image, (background, noise), LEVEL)
    assert np.mean(judged > background + LEVEL * noise) == pytest.approx(SHARE, rel=0.4)
