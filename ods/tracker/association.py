"""Which echo belongs to which object: statistical gate, then global nearest neighbour.

Everything is compared in the sonar's own coordinates, along and across the line of sight, where range and bearing
noise keep their shape; the uncertainty of prediction and pose is part of it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ods.geometry import Array
from ods.tracker.measurement import Estimate, Sight, bearing_difference
from ods.tracker.scan import Echoes
from ods.tracker.settings import EchoSettings

Rows = NDArray[np.intp]

LEAST_RADIUS_EVIDENCE = -4.5
"""A radius that does not agree never counts for more than a 3-sigma difference: echoes merge, split and change."""


@dataclass(frozen=True, slots=True)
class Pairs:
    """Objects and the echoes given to them: (k,) each."""

    objects: Rows
    echoes: Rows
    evidence: Array
    """Log of the likelihood of the echo from this object over that of a false alarm."""


@dataclass(frozen=True, slots=True)
class ClutterDensity:
    """False alarms at the place of each of m echoes."""

    per_m2: Array
    """(m,) number a scan per m^2."""
    radius: Array
    """(m,) probability density of the echo's radius among them, 1/m."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """All objects with all echoes, (n, m)."""

    evidence: Array
    """Log of the likelihood of the echo from this object over that of a false alarm; -inf outside the gate."""
    separation: Array
    """Horizontal distance between prediction and echo, m."""


def compare(
    sight: Sight, estimate: Estimate, echoes: Echoes, clutter: ClutterDensity, settings: EchoSettings
) -> Comparison:
    """Gate all pairs and weigh those inside."""
    along = echoes.range_m[None, :] - sight.range_m[:, None]
    across = bearing_difference(echoes.bearing, sight.bearing) * sight.horizontal[:, None]
    s_along = sight.along[:, None] + (echoes.sigma_range**2)[None, :]
    s_across = sight.across[:, None] + np.outer(sight.horizontal**2, echoes.sigma_bearing**2)
    s_mixed = sight.mixed[:, None]
    determinant = s_along * s_across - s_mixed**2
    distance = (s_across * along**2 - 2.0 * s_mixed * along * across + s_along * across**2) / determinant
    evidence = -0.5 * (distance + np.log(determinant))
    evidence += np.log(settings.detection_probability / (2.0 * np.pi * clutter.per_m2))
    evidence += _radius_evidence(estimate, echoes, clutter.radius)
    evidence[distance > settings.gate_sigmas**2] = -np.inf
    return Comparison(evidence, np.hypot(along, across))


def _radius_evidence(estimate: Estimate, echoes: Echoes, clutter: Array) -> Array:
    """Return (n, m) log-likelihood ratios of the radii: this object's against a false alarm's."""
    variance = estimate.radius_variance[:, None] + (echoes.sigma_radius**2)[None, :]
    difference = echoes.radius[None, :] - estimate.radius[:, None]
    ratio = -0.5 * (difference**2 / variance + np.log(2.0 * np.pi * variance)) - np.log(clutter)
    return np.maximum(ratio, LEAST_RADIUS_EVIDENCE)


def associate(evidence: Array, groups: list[Rows], miss: float) -> Pairs:
    """Give each object at most one echo and each echo to at most one object.

    The groups of objects choose one after the other; inside a group the sum of evidence is the largest possible.
    `miss`: log-likelihood of seeing nothing of an object; a pair that explains less than a miss and a false alarm is
    left apart.
    """
    free = np.arange(evidence.shape[1])
    objects, echoes = [], []
    for group in groups:
        rows, columns = _best_assignment(evidence[np.ix_(group, free)] - miss)
        objects.append(group[rows])
        echoes.append(free[columns])
        free = np.delete(free, columns)
    n, m = np.concatenate(objects), np.concatenate(echoes)
    return Pairs(n, m, evidence[n, m])


def _best_assignment(worth: Array) -> tuple[Rows, Rows]:
    """Return rows and columns of the assignment with the largest sum of positive worths."""
    if worth.size == 0:
        nothing = np.zeros(0, np.intp)
        return nothing, nothing
    gain = np.maximum(worth, 0.0)
    rows, columns = linear_sum_assignment(gain, maximize=True)
    real = gain[rows, columns] > 0.0
    return rows[real], columns[real]


def fragments(separation: Array, radius: Array, objects: Rows, echoes: Rows) -> tuple[Rows, Rows]:
    """Find parts of large objects: each of `echoes` inside the circle of one of `objects`, with the nearest such one.

    `separation`: (n, m) distances; `radius`: (n,). Returns objects and echoes of the pairs, the echo nearest to its
    object's centre first; an object may come more than once.
    """
    if not len(objects) or not len(echoes):
        nothing = np.zeros(0, np.intp)
        return nothing, nothing
    distance = separation[np.ix_(objects, echoes)]
    excess = distance - radius[objects, None]
    nearest = np.argmin(excess, axis=0)
    columns = np.arange(len(echoes))
    columns = columns[excess[nearest, columns] < 0.0]
    columns = columns[np.argsort(distance[nearest[columns], columns])]
    return objects[nearest[columns]], echoes[columns]
