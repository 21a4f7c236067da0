"""Standard deviations of an echo's circle, fitted to the errors at known objects (sigmas.h)."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.pipeline.measure.features import Features
from ods.pipeline.measure.laws import RANGE_HIDDEN, RANGE_OUT, SIGMAS_HIDDEN, SIGMAS_OUT

LAWS = SIGMAS_HIDDEN, SIGMAS_OUT, RANGE_HIDDEN, RANGE_OUT


class Sigmas(NamedTuple):
    """Standard deviations."""

    near_m: float
    range_m: float
    radius_m: float
    bearing_rad: float


def sigmas_of(features: Features, point_m: float, beside_m: float, range_m: float, dr_m: float) -> Sigmas:
    """Return the standard deviations of an echo of these features.

    point_m: width of a point along the line of sight; beside_m: the largest across it; dr_m: the columns' spacing.
    """
    sigmas = np.empty(len(Sigmas._fields))
    native.sigmas_of(np.array(features), point_m, beside_m, range_m, dr_m, LAWS, sigmas)
    return Sigmas(*sigmas.tolist())


def outputs_of(inputs: Features, hidden: Floats, out: Floats) -> Floats:
    """Return the logarithms of the variances, in widths of a point, (m,).

    hidden: (k + 1, n) factors of the first k inputs, the last row the constants; out: (n + 1, m) alike.
    """
    sums = np.empty(out.shape[1])
    native.outputs_of(np.array(inputs), hidden, out, sums)
    return sums
