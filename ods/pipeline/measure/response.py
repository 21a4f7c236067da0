"""How wide a point is in an image: speckle through a filter is correlated as far as the filter and the pulse reach."""

import math

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled.kernel import kernel

_PAIRS = 2048
"""Neighbouring cells that are compared."""
_SPECKLE = 1.6
"""Cells louder than this, in multiples of the background, may be an echo's."""
_LEAST = 1.0
"""Columns: what is taken where there is no speckle, and for what is correlated less."""
_LEAST_VARIANCE = 1e-3
"""Of speckle, in units of the square of the background: of a mean over 200 cells it is more."""
_FULL_WIDTH = 2.3548
"""Width at half its level of a Gaussian in units of its standard deviation."""
_NARROWEST, _WIDEST = 1.05, 3.99
"""What two columns' distance adds to one column's: 1 for white speckle, 4 for what is smooth."""
_EVERY_BEAM, _STRETCH = 6, 144
"""Beams and columns, and of such stretches"""
_LEAST_SHARE = 0.1
"""so many have less relief than that whose speckle is taken."""


@kernel
def point_width(image: Image, background: float) -> float:
    """Return the width, columns, that a point has at half its level along the range.

    A Gaussian filter of standard deviation s makes white speckle correlated by exp(-1 / 4 s^2) from column to column.
    As loud cells are left out, narrow points come out narrower, by up to a fifth.
    """
    beams, columns = image.shape[0], image.shape[1] - 1
    step = max(1, beams * columns // _PAIRS)
    most = np.float32(_SPECKLE * background)
    count, total, squares, products = 0, 0.0, 0.0, 0.0
    for beam in range(beams):
        row = image[beam]
        for j in range(beam % step, columns, step):
            x, y = row[j], row[j + 1]
            if 0.0 < x < most and 0.0 < y < most:
                count += 1
                total += x + y
                squares += x * x + y * y
                products += x * y
    if count == 0:
        return _LEAST
    mean = 0.5 * total / count
    variance, shared = 0.5 * squares / count - mean * mean, products / count - mean * mean
    if variance < _LEAST_VARIANCE * background**2 or shared <= 0.0:
        return _LEAST
    return max(_FULL_WIDTH * 0.5 / math.sqrt(max(-math.log(min(shared / variance, 1.0)), 1e-4)), _LEAST)


@kernel
def response_width(image: Image, background: float) -> float:
    """Return the width, columns, that the filter and the pulse give a point; 0 where no speckle tells it.

    Of what `point_width` counts, without what the bottom's own relief adds. With q the correlation of neighbours, cells
    two columns apart differ by 1 + q + q^2 + q^3 times as much (mean squares) as neighbours do, as correlations of
    Gaussian shape are q, q^4, ...; slower changes hardly move that. Where short ripples do, in some stretches of the
    image they do not: so it is that of the stretches in which it is least.
    """
    most = np.float32(_SPECKLE * background)
    ratios, count = np.empty(image.shape[0] // _EVERY_BEAM * (image.shape[1] // _STRETCH) + 1), 0
    for beam in range(_EVERY_BEAM // 2, image.shape[0], _EVERY_BEAM):
        for first in range(0, image.shape[1] - _STRETCH + 1, _STRETCH):
            ratio = _growth(image[beam, first : first + _STRETCH], most)
            if ratio > 0.0 and count < ratios.size:
                ratios[count] = ratio
                count += 1
    if count == 0:
        return 0.0
    told = np.sort(ratios[:count])[int(_LEAST_SHARE * count)]
    shared = _root(min(max(told, _NARROWEST), _WIDEST))
    return max(_FULL_WIDTH * 0.5 / math.sqrt(-math.log(shared)), _LEAST)


@kernel
def _growth(row: Floats32, most: np.float32) -> float:
    """Return how many times as much cells two columns apart differ as neighbours, mean squares; 0: not known."""
    near, far, count = np.float32(0.0), np.float32(0.0), 0
    for j in range(row.size - 2):
        x, y, z = row[j], row[j + 1], row[j + 2]
        if 0.0 < x < most and 0.0 < y < most and 0.0 < z < most:
            near += (y - x) * (y - x) + (z - y) * (z - y)
            far += (z - x) * (z - x)
            count += 1
    return float(2.0 * far / near) if near > 0.0 and 2 * count > row.size else 0.0


@kernel
def _root(ratio: float) -> float:
    """Return q of 1 + q + q^2 + q^3 = ratio, by Newton: the sum is convex and grows, so from 1 on it converges."""
    q = 1.0
    for _ in range(8):
        q -= (1.0 + q * (1.0 + q * (1.0 + q)) - ratio) / (1.0 + q * (2.0 + 3.0 * q))
    return q
