"""Which echo belongs to which object: statistical gate, then global nearest neighbour.

Everything is compared in the sonar's own coordinates, along and across the line of sight, where range and bearing
noise keep their shape; the uncertainty of prediction and pose is part of it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ods.geometry import Array, wrap_angle
from ods.tracker.belief import Belief
from ods.tracker.measurement import Sight
from ods.tracker.scan import Echoes
from ods.tracker.settings import EchoSettings

Rows = NDArray[np.intp]

IMPOSSIBLE = 1e-300
"""Keeps the logarithm of a likelihood that is too small for a number finite."""
LEAST_RADIUS_EVIDENCE = -4.5
"""A radius that does not agree never counts for more than a 3-sigma difference: echoes merge, split and change."""


@dataclass(frozen=True, slots=True)
class ClutterDensity:
    """False alarms at the place of each of m echoes."""

    per_m2: Array
    """(m,) number a scan per m^2."""
    radius: Array
    """(m,) probability density of the echo's radius among them, 1/m."""


@dataclass(frozen=True, slots=True)
class Candidates:
    """All pairs of an object and an echo inside its gate: (p,) each."""

    objects: Rows
    echoes: Rows
    evidence: Array
    """Log of the likelihood of the echo from this object over that of a false alarm."""

    def take(self, chosen: NDArray[np.bool_]) -> "Candidates":
        """Return the pairs of a mask."""
        return Candidates(self.objects[chosen], self.echoes[chosen], self.evidence[chosen])

    def joined(self, other: "Candidates") -> "Candidates":
        """Return the pairs of both."""
        return Candidates(
            np.concatenate([self.objects, other.objects]),
            np.concatenate([self.echoes, other.echoes]),
            np.concatenate([self.evidence, other.evidence]),
        )


def candidates(
    sights: Sight, belief: Belief, echoes: Echoes, clutter: ClutterDensity, settings: EchoSettings
) -> Candidates:
    """Return the pairs that agree by at least one of the object's hypotheses.

    `sights`: what the sonar should see, (h, n) arrays, by the h hypotheses of n objects.
    """
    objects, columns = _near_in_range(sights, echoes, settings.gate_sigmas)
    horizontal = sights.horizontal[:, objects]
    along = echoes.range_m[columns] - sights.range_m[:, objects]
    across = wrap_angle(echoes.bearing[columns] - sights.bearing[:, objects]) * horizontal
    s_along = sights.along[:, objects] + echoes.sigma_range[columns] ** 2
    s_across = sights.across[:, objects] + (horizontal * echoes.sigma_bearing[columns]) ** 2
    s_mixed = sights.mixed[:, objects]
    determinant = s_along * s_across - s_mixed**2
    distance = (s_across * along**2 - 2.0 * s_mixed * along * across + s_along * across**2) / determinant
    gated = np.flatnonzero((distance <= settings.gate_sigmas**2).any(axis=0))
    objects, columns = objects[gated], columns[gated]
    density = belief.weight[:, objects] * np.exp(-0.5 * distance[:, gated]) / np.sqrt(determinant[:, gated])
    total = density.sum(axis=0) * settings.detection_probability / (2.0 * np.pi * clutter.per_m2[columns])
    evidence = np.log(np.maximum(total, IMPOSSIBLE)) + _radius_evidence(belief, echoes, clutter, objects, columns)
    return Candidates(objects, columns, evidence)


def _near_in_range(sights: Sight, echoes: Echoes, gate_sigmas: float) -> tuple[Rows, Rows]:
    """Return the pairs whose ranges agree; echoes are sorted by range, so that no pair far apart is looked at."""
    if not len(echoes) or not sights.range_m.size:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    order = np.argsort(echoes.range_m)
    in_order = echoes.range_m[order]
    width = gate_sigmas * np.sqrt(sights.along + echoes.sigma_range.max() ** 2)
    # The gate is an ellipse: nothing inside it is farther along the line of sight than `width`.
    first = np.searchsorted(in_order, (sights.range_m - width).min(axis=0))
    count = np.searchsorted(in_order, (sights.range_m + width).max(axis=0), side="right") - first
    objects = np.repeat(np.arange(len(first)), count)
    within = np.arange(len(objects)) - np.repeat(np.cumsum(count) - count, count)
    return objects, order[np.repeat(first, count) + within]


def _radius_evidence(belief: Belief, echoes: Echoes, clutter: ClutterDensity, objects: Rows, columns: Rows) -> Array:
    """Return (p,) log-likelihood ratios of the radii: this object's against a false alarm's."""
    variance = belief.radius_variance[objects] + echoes.sigma_radius[columns] ** 2
    difference = echoes.radius[columns] - belief.radius[objects]
    ratio = -0.5 * (difference**2 / variance + np.log(2.0 * np.pi * variance)) - np.log(clutter.radius[columns])
    return np.maximum(ratio, LEAST_RADIUS_EVIDENCE)


def worth_of(found: Candidates, visibility: Array, detection_probability: float) -> Array:
    """Return (p,) how much better a pair explains the image than a missed object and a false alarm: log-likelihoods.

    `visibility`: (n,) probability that the object, if it exists, is in view and gives echoes at all just now.
    """
    visible = np.maximum(visibility[found.objects], IMPOSSIBLE)
    return np.asarray(found.evidence + np.log(visible) - np.log1p(-detection_probability * visible))


def associate(found: Candidates, worth: Array, first: NDArray[np.bool_], echoes: int) -> Candidates:
    """Give each object at most one echo and each echo to at most one object; return the pairs.

    The objects of the mask `first` choose before the others; within each group the sum of worths, all above 0, is the
    largest possible. `echoes`: how many there are.
    """
    chosen = np.zeros(len(worth), bool)
    senior = first[found.objects]
    _choose(found, worth, senior & (worth > 0.0), chosen)
    taken = np.zeros(echoes, bool)
    taken[found.echoes[chosen]] = True
    _choose(found, worth, ~senior & (worth > 0.0) & ~taken[found.echoes], chosen)
    return found.take(chosen)


def _choose(found: Candidates, worth: Array, group: NDArray[np.bool_], chosen: NDArray[np.bool_]) -> None:
    """Mark those pairs of the mask `group` that make the assignment with the largest sum of worths, all above 0."""
    pairs = group.nonzero()[0]
    if not len(pairs):
        return
    objects, echoes = found.objects[pairs], found.echoes[pairs]
    rivals = np.bincount(objects)[objects] + np.bincount(echoes)[echoes]
    chosen[pairs[rivals == 2]] = True
    disputed = rivals > 2
    if not disputed.any():
        return
    pairs = pairs[disputed]
    objects, rows = np.unique(objects[disputed], return_inverse=True)
    echoes, columns = np.unique(echoes[disputed], return_inverse=True)
    matrix = np.zeros((len(objects), len(echoes)))
    matrix[rows, columns] = worth[pairs]
    best = np.zeros(matrix.shape, bool)
    best[linear_sum_assignment(matrix, maximize=True)] = True
    chosen[pairs[best[rows, columns]]] = True
