"""The circle that stands for an echo's body, and how well it is known."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel
from ods.pipeline.measure.features import features_of
from ods.pipeline.measure.kinds import body_of
from ods.pipeline.measure.laws import BODY_HIDDEN, BODY_OUT, SIGMAS_HIDDEN, SIGMAS_OUT
from ods.pipeline.measure.layers import outputs_of
from ods.pipeline.measure.shape import Shape

_SMALLEST = 0.5
"""Least radius, widths of a point."""
_HIDDEN_M = 5.0
"""Standard deviation of the place of an object of which the fan's edge hides a part."""
_LEAST_VARIANCE, _MOST_VARIANCE = -4.6, 12.0
"""Logarithms, in units of the width of a point: nothing is known to less than a tenth of that."""


class Circle(NamedTuple):
    """A circle in the sonar's plane, with standard deviations: the fields of `ods.messages.Detection`."""

    range_m: float
    bearing_rad: float
    radius_m: float
    sigma_range_m: float
    sigma_bearing_rad: float
    sigma_radius_m: float
    near_m: float
    sigma_near_m: float


@kernel
def circle_of(shape: Shape) -> Circle:
    """Return the circle of an echo of this shape: the mean over the kinds of objects that it may show."""
    of, point = features_of(shape), shape.depth.point_m
    body = body_of(shape, outputs_of(of, BODY_HIDDEN, BODY_OUT))
    variances = outputs_of(of, SIGMAS_HIDDEN, SIGMAS_OUT)
    distance = body.near_m + body.behind_m
    circle = Circle(
        distance, shape.bearing_rad, max(body.radius_m, _SMALLEST * point),
        _sigma(point, variances, 1), _sigma(point, variances, 3) / max(distance, 1e-3), _sigma(point, variances, 2),
        body.near_m, _sigma(point, variances, 0),
    )  # fmt: skip
    return _cut_off(circle) if shape.cut_off else circle


@kernel
def _sigma(point_m: float, variances: Floats, which: int) -> float:
    """Return a standard deviation, m. variances: logarithms, in units of the width of a point, of near edge, range,
    radius, and place across.
    """
    return point_m * math.exp(0.5 * min(max(variances[which], _LEAST_VARIANCE), _MOST_VARIANCE))


@kernel
def _cut_off(circle: Circle) -> Circle:
    """Widen the standard deviations of an echo that the fan's edge cuts off.

    How far the object goes on beyond the edge nobody knows, and the error stays the same from ping to ping.
    """
    return Circle(
        circle.range_m, circle.bearing_rad, circle.radius_m,
        np.hypot(circle.sigma_range_m, circle.radius_m),
        np.hypot(circle.sigma_bearing_rad, _HIDDEN_M / max(circle.range_m, _HIDDEN_M)),
        np.hypot(circle.sigma_radius_m, _HIDDEN_M),
        circle.near_m, circle.sigma_near_m,
    )  # fmt: skip
