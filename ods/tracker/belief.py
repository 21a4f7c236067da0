"""What an observer believes of its objects: one or more hypotheses of how each moves, and their mixture."""

from typing import NamedTuple

import numpy as np

from ods.geometry import Array
from ods.kernel import kernel


class Belief(NamedTuple):
    """h hypotheses of n objects; positions are north, east, down."""

    weight: Array
    """(h, n) probability of each hypothesis; they sum to 1."""
    position: Array
    """(h, 3, n)."""
    variance: Array
    """(h, 3, n) of the position."""
    covariance_ne: Array
    """(h, n) of north and east."""
    radius: Array
    """(n,)."""
    radius_variance: Array
    """(n,)."""
    static: Array
    """(n,) probability that the object does not move."""


class Estimate(NamedTuple):
    """Mean and covariance of n objects."""

    position: Array
    """(3, n)."""
    variance: Array
    """(3, n)."""
    covariance_ne: Array
    """(n,)."""
    radius: Array
    radius_variance: Array
    static: Array


def mixture(belief: Belief) -> Estimate:
    """Return mean and covariance of the hypotheses taken together."""
    moments = _moments(belief)
    return Estimate(moments[0:3], moments[3:6], moments[6], belief.radius, belief.radius_variance, belief.static)


@kernel
def _moments(belief: Belief) -> Array:
    """Return (7, n): mean, variances, and the covariance of north and east."""
    hypotheses, _, n = belief.position.shape
    moments = np.zeros((7, n))
    for i in range(n):
        for h in range(hypotheses):
            for axis in range(3):
                moments[axis, i] += belief.weight[h, i] * belief.position[h, axis, i]
        for h in range(hypotheses):
            weight = belief.weight[h, i]
            for axis in range(3):
                offset = belief.position[h, axis, i] - moments[axis, i]
                moments[3 + axis, i] += weight * (belief.variance[h, axis, i] + offset**2)
            north, east = belief.position[h, 0, i] - moments[0, i], belief.position[h, 1, i] - moments[1, i]
            moments[6, i] += weight * (belief.covariance_ne[h, i] + north * east)
    return moments
