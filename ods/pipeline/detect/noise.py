"""Background of an image: its level, how much that fluctuates, and how high it seldom is."""

from math import exp, expm1, log, log1p
from statistics import NormalDist

import numpy as np

from ods.base.arrays import Floats, Image
from ods.compiled import native

_SAMPLES = 4096
"""Cells looked at: the spread of Rayleigh speckle is then known to about 3 %."""
_TAIL_SAMPLES = 4 * _SAMPLES
LEAST_NOISE = 0.02
"""Of the background: keeps the rounding of a noiseless image from becoming echoes."""
_NORMAL = NormalDist()
_SPREAD = np.array([0.5, 0.8413])
"""Quantiles that are one standard deviation apart in a normal distribution."""
_HIGH = 1.5
"""Standard deviations of the quantile that shows how the tail goes on: farther out echoes fill more of it."""
_TAIL = np.array([*_SPREAD, _NORMAL.cdf(_HIGH)])
_POWERS = 1e-3, 4.0
"""Least and greatest power of an amplitude that may be normal; nearly 0: the amplitude is log-normal."""


def background_and_noise(image: Image) -> tuple[float, float]:
    """Return the median of image (beams, samples) and the distance from there to its 84 % quantile.

    For a normal distribution that distance is the standard deviation; for speckle it takes the long upper tail into
    account. Echoes that fill 1 % of the image raise it by 4 %, 5 % by a fifth. Cells at 0 hold no data and do not
    count; (0, 0) when there are no others, or when the mean is not finite.
    """
    middle, upper = _quantiles(image, _SAMPLES, _SPREAD)
    return middle, upper - middle


def level_at_rate(image: Image, rate: float) -> float:
    """Return the level that this share of the cells of image (beams, samples) exceeds where there are no echoes.

    A power of the amplitude is nearly normal (G. Box, D. Cox, J. R. Stat. Soc. B 26, 1964): 2/3 for speckle of one look
    (E. Wilson, M. Hilferty, PNAS 17, 1931), others for what is smoothed or K-distributed. Three quantiles show which.
    """
    middle, upper, high = _quantiles(image, _TAIL_SAMPLES, _TAIL)
    if upper <= (1.0 + LEAST_NOISE) * middle:
        return (1.0 + LEAST_NOISE) * middle
    one_sigma, at_high = log(upper / middle), log(high / middle)
    low, most = _POWERS
    while most - low > _POWERS[0]:
        power = 0.5 * (low + most)
        if expm1(power * at_high) < _HIGH * expm1(power * one_sigma):
            low = power
        else:
            most = power
    return middle * exp(log1p(_NORMAL.inv_cdf(1.0 - rate) * expm1(low * one_sigma)) / low)


def _quantiles(image: Image, cells: int, shares: Floats) -> list[float]:
    """Return the quantiles of some cells of image (beams, samples)."""
    quantiles = np.empty(len(shares))
    stride = max(1, image.size // cells) | 1  # odd: else it could fall in step with the rows
    native.noise_quantiles(image, stride, shares, quantiles)
    return quantiles.tolist()
