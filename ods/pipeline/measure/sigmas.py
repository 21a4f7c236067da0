"""How well an echo's near edge, radius and bearing are known: standard deviations as fitted to known bodies' errors.

The law is a smooth function of two layers, the first of which saturates: beyond what it was fitted to it stays finite.
benchmarks/circle_laws.py fits it.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel
from ods.pipeline.measure.features import Features
from ods.pipeline.measure.laws import SIGMAS_HIDDEN, SIGMAS_OUT

_ROUNDING = 0.289
"""Standard deviation of what is rounded to whole columns, in columns: no place along the line of sight or across it is
claimed to be known better."""
_LEAST, _MOST = -3.0, 5.0
"""Logarithms of standard deviations in widths of a point that the law may claim."""
_NEAREST_M = 1e-3


class Sigmas(NamedTuple):
    """Standard deviations."""

    near_m: float
    radius_m: float
    bearing_rad: float


@kernel
def sigmas_of(features: Features, point_m: float, beside_m: float, range_m: float, dr_m: float) -> Sigmas:
    """Return the standard deviations of an echo of these features.

    point_m: width of a point along the line of sight; beside_m: the largest across it; dr_m: the columns' spacing.
    """
    told = outputs_of(features, SIGMAS_HIDDEN, SIGMAS_OUT)
    for k in range(told.size):
        told[k] = max(point_m * math.exp(min(max(0.5 * told[k], _LEAST), _MOST)), _ROUNDING * dr_m)
    across = max(min(told[2], beside_m), _ROUNDING * dr_m)
    return Sigmas(told[0], told[1], across / max(range_m, _NEAREST_M))


@kernel
def outputs_of(inputs: Features, hidden: Floats, out: Floats) -> Floats:
    """Return the logarithms of the variances of near edge, radius and place across, in widths of a point, (3,).

    hidden: (inputs + 1, n) factors, the last row the constants; out: (n + 1, 3) alike.
    """
    count, last = hidden.shape[1], hidden.shape[0] - 1
    sums = np.empty(out.shape[1])
    for k in range(sums.size):
        sums[k] = out[count, k]
    for j in range(count):
        total = hidden[last, j]
        for i in range(len(inputs)):
            total += inputs[i] * hidden[i, j]
        bent = math.tanh(total)
        for k in range(sums.size):
            sums[k] += bent * out[j, k]
    return sums
