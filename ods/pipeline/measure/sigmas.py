"""How well an echo's circle is known: standard deviations as fitted to known bodies' errors.

A law is a smooth function of two layers, the first of which saturates: beyond what it was fitted to it stays finite.
benchmarks/circle_laws.py fits them: one of near edge, radius and place across, one of the range.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel
from ods.pipeline.measure.features import Features
from ods.pipeline.measure.laws import RANGE_HIDDEN, RANGE_OUT, SIGMAS_HIDDEN, SIGMAS_OUT

_ROUNDING = 0.289
"""Standard deviation of what is rounded to whole columns, in columns: no place along the line of sight or across it is
claimed to be known better."""
_LEAST, _MOST = -3.0, 5.0
"""Logarithms of standard deviations in widths of a point that the law may claim."""
_NEAREST_M = 1e-3


class Sigmas(NamedTuple):
    """Standard deviations."""

    near_m: float
    range_m: float
    radius_m: float
    bearing_rad: float


@kernel
def sigmas_of(features: Features, point_m: float, beside_m: float, range_m: float, dr_m: float) -> Sigmas:
    """Return the standard deviations of an echo of these features.

    point_m: width of a point along the line of sight; beside_m: the largest across it; dr_m: the columns' spacing.
    """
    least = _ROUNDING * dr_m
    told = outputs_of(features, SIGMAS_HIDDEN, SIGMAS_OUT)
    near, radius, across = (
        _sigma(told[0], point_m, least),
        _sigma(told[1], point_m, least),
        _sigma(told[2], point_m, least),
    )
    along = _sigma(outputs_of(features, RANGE_HIDDEN, RANGE_OUT)[0], point_m, least)
    across = max(min(across, beside_m), least)
    return Sigmas(near, along, radius, across / max(range_m, _NEAREST_M))


@kernel
def _sigma(told: float, point_m: float, least: float) -> float:
    """Return the standard deviation, m, of which the law tells the logarithm of the variance, in widths of a point."""
    return max(point_m * math.exp(min(max(0.5 * told, _LEAST), _MOST)), least)


@kernel
def outputs_of(inputs: Features, hidden: Floats, out: Floats) -> Floats:
    """Return the logarithms of the variances, in widths of a point, (m,).

    hidden: (k + 1, n) factors of the first k inputs, the last row the constants; out: (n + 1, m) alike.
    """
    count, last = hidden.shape[1], hidden.shape[0] - 1
    sums = np.empty(out.shape[1])
    for k in range(sums.size):
        sums[k] = out[count, k]
    totals = hidden[last].copy()
    for i in range(last):  # by rows: then the processor takes several at once
        for j in range(count):
            totals[j] += inputs[i] * hidden[i, j]
    for j in range(count):
        bent = math.tanh(totals[j])
        for k in range(sums.size):
            sums[k] += bent * out[j, k]
    return sums
