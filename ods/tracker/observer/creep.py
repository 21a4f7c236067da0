"""What an object at rest may have crept unseen: the velocities that echoes do not tell from zero yet.

An object that moves slowly across the line of sight seems to rest for long, and the average of its echoes lags behind
it by more than that average's own standard deviation. How likely it rests is found against velocities of
`velocity_sigma`, among which so slow ones are few: whoever meets one is misled. So whether it creeps is judged once
more, for the covariance alone and whatever its speed, by how far the two estimates of its place are apart. If it rests,
the average is the best estimate there is, and the covariance of the difference is the difference of the covariances
(J. A. Hausman, Specification tests in econometrics, Econometrica 46, 1978). Both are compared at the same height, as
each hypothesis has learned its own, and what the unseen does to one more than to the other is part of it.
"""

import math
from typing import NamedTuple

from ods.base.arrays import Floats
from ods.compiled.kernel import inlined
from ods.tracker.measurement.model import UNSEEN
from ods.tracker.observer.sensitivity import Four

EVEN_SQUARE = 4.0
"""Squared distance of both estimates over its covariance, 2 on average at rest, at which it creeps as likely as not."""
LEAST_MORE = 1e-9
"""Of the variance at rest: where that of one that moves is larger by less, both began at one place just now."""
RESTING = 0
"""The hypothesis at rest; those after it move."""

Three = tuple[float, float, float]


class Away(NamedTuple):
    """The estimate of an object that moves, seen from that of one at rest."""

    north: float
    east: float
    nn: float
    """By how much its variance north is larger, m^2,"""
    ee: float
    ne: float
    creeps: float
    """Probability that the object creeps."""


class Unseen(NamedTuple):
    """Height, its square, attitude and climb, on which places depend, of an object at rest: see `sensitivity`."""

    lower: Four
    """By how much they are more than what the hypotheses that move are told for,"""
    mean: Four
    """and than what that at rest is told for."""
    variance: Four


@inlined
def creep(away: Away) -> Three:
    """Return variances of north and east, m^2, and their covariance, that are to be added to those at rest.

    With d the distance of both estimates, C its covariance without the unseen and c the probability that it creeps:
    c (C + d d').
    """
    return (
        away.creeps * (away.nn + away.north**2),
        away.creeps * (away.ee + away.east**2),
        away.creeps * (away.ne + away.north * away.east),
    )


@inlined
def away(share: Floats, places: tuple[Floats, Floats, Floats], derivatives: Floats, i: int, unseen: Unseen) -> Away:
    """Compare both estimates of object i; `places`: position, variance, covariance; arrays as in `HorizontalState`."""
    position, variance, covariance = places
    north, east = -position[RESTING, 0, i], -position[RESTING, 1, i]
    nn, ee, ne = -variance[RESTING, 0, i], -variance[RESTING, 1, i], -covariance[RESTING, i]
    for m in range(len(share)):
        north += share[m, i] * position[1 + m, 0, i]
        east += share[m, i] * position[1 + m, 1, i]
        nn += share[m, i] * variance[1 + m, 0, i]
        ee += share[m, i] * variance[1 + m, 1, i]
        ne += share[m, i] * covariance[1 + m, i]
    all_nn, all_ee, all_ne = nn, ee, ne
    for c in range(UNSEEN):
        by_n, by_e = 0.0, 0.0
        for m in range(len(share)):
            by_n += share[m, i] * derivatives[1 + m, c, 0, i]
            by_e += share[m, i] * derivatives[1 + m, c, 1, i]
        more_n, more_e = by_n - derivatives[RESTING, c, 0, i], by_e - derivatives[RESTING, c, 1, i]
        north += by_n * unseen.lower[c] + more_n * unseen.mean[c]
        east += by_e * unseen.lower[c] + more_e * unseen.mean[c]
        all_nn += more_n**2 * unseen.variance[c]
        all_ee += more_e**2 * unseen.variance[c]
        all_ne += more_n * more_e * unseen.variance[c]
    determinant = all_nn * all_ee - all_ne**2
    least_n, least_e = LEAST_MORE * variance[RESTING, 0, i], LEAST_MORE * variance[RESTING, 1, i]
    if nn <= least_n or ee <= least_e or determinant <= 0.0:
        return Away(north, east, nn, ee, ne, 0.0)
    square = (all_ee * north**2 - 2.0 * all_ne * north * east + all_nn * east**2) / determinant
    return Away(north, east, nn, ee, ne, 0.5 * (1.0 + math.tanh(0.5 * (square - EVEN_SQUARE))))
