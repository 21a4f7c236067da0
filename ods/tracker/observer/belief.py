"""What an observer believes of its objects: one or more hypotheses of how each moves, and their mixture."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.kernel import kernel


class Belief(NamedTuple):
    """h hypotheses of n objects; positions are north, east, down."""

    weight: Floats
    """(h, n) probability of each hypothesis; they sum to 1."""
    position: Floats
    """(h, 3, n)."""
    variance: Floats
    """(h, 3, n) of the position."""
    covariance_ne: Floats
    """(h, n) of north and east."""
    radius: Floats
    """(n,)."""
    radius_variance: Floats
    """(n,)."""
    static: Floats
    """(n,) probability that the object does not move."""


class Estimate(NamedTuple):
    """Mean and covariance of n objects."""

    position: Floats
    """(3, n)."""
    variance: Floats
    """(3, n)."""
    covariance_ne: Floats
    """(n,)."""
    radius: Floats
    radius_variance: Floats
    static: Floats


def mixture(belief: Belief) -> Estimate:
    """Return mean and covariance of the hypotheses taken together."""
    moments = _moments(belief)
    return Estimate(moments[0:3], moments[3:6], moments[6], belief.radius, belief.radius_variance, belief.static)


@kernel
def _moments(belief: Belief) -> Floats:
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
