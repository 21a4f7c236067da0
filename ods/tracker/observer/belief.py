"""What an observer believes of its objects: one or more hypotheses of how each moves, and their mixture."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel


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
    """(n,) the filters' own: it follows their next correction."""
    radius_variance: Floats
    """(n,), too."""
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
    """(n,) and the next two: as in `Belief`."""
    radius_variance: Floats
    static: Floats


def moment_match(belief: Belief) -> Estimate:
    """Return mean and covariance of the hypotheses taken together: the first two moments of their mixture."""
    moments, covariance_ne = _moments(belief.weight, belief.position, belief.variance, belief.covariance_ne)
    mean, variance = moments
    return Estimate(mean, variance, covariance_ne, belief.radius, belief.radius_variance, belief.static)


@kernel
def _moments(share: Floats, position: Floats, variance: Floats, covariance_ne: Floats) -> tuple[Floats, Floats]:
    """Return (2, 3, n) mean and variance, and (n,) the covariance, of hypotheses with the probabilities `share`."""
    hypotheses, _, n = position.shape
    moments, mixed = np.zeros((2, 3, n)), np.zeros(n)
    mean, spread = moments[0], moments[1]
    for i in range(n):
        for h in range(hypotheses):
            for axis in range(3):
                mean[axis, i] += share[h, i] * position[h, axis, i]
        for h in range(hypotheses):
            weight = share[h, i]
            for axis in range(3):
                offset = position[h, axis, i] - mean[axis, i]
                spread[axis, i] += weight * (variance[h, axis, i] + offset**2)
            north, east = position[h, 0, i] - mean[0, i], position[h, 1, i] - mean[1, i]
            mixed[i] += weight * (covariance_ne[h, i] + north * east)
    return moments, mixed
