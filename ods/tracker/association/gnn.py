"""Which echo belongs to which object: statistical gate, and global nearest neighbour among what is inside.

Everything is compared in the sonar's own coordinates, along and across the line of sight, where range and bearing
noise keep their shape; the uncertainty of prediction and pose is part of it.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.base.assignment import best_columns
from ods.base.kernel import kernel
from ods.tracker.measurement.model import Sight, wrapped
from ods.tracker.measurement.scan import BEARING, RADIUS, RANGE, SIGMA_BEARING, SIGMA_RADIUS, SIGMA_RANGE, Echoes
from ods.tracker.observer.belief import Belief, Estimate
from ods.tracker.settings import EchoSettings

IMPOSSIBLE = 1e-300
"""Keeps the logarithm of a likelihood that is too small for a number finite."""
LEAST_RADIUS_EVIDENCE = -4.5
"""A radius that does not agree never counts for more than a 3-sigma difference: echoes merge, split and change."""


class ClutterDensity(NamedTuple):
    """False alarms at the place of each of m echoes."""

    per_m2: Floats
    """(m,) number a scan per m^2."""
    radius: Floats
    """(m,) probability density of the echo's radius among them, 1/m."""


class Candidates(NamedTuple):
    """All pairs of an object and an echo inside its gate: (p,) each."""

    objects: Indices
    echoes: Indices
    evidence: Floats
    """Log of the likelihood of the echo from this object over that of a false alarm."""

    def take(self, chosen: Mask) -> "Candidates":
        """Return the pairs of a mask."""
        return Candidates(self.objects[chosen], self.echoes[chosen], self.evidence[chosen])

    def joined(self, other: "Candidates") -> "Candidates":
        """Return the pairs of both."""
        return Candidates(
            np.concatenate([self.objects, other.objects]),
            np.concatenate([self.echoes, other.echoes]),
            np.concatenate([self.evidence, other.evidence]),
        )


class Pairing(NamedTuple):
    """Which objects were seen, and by what: k of them."""

    pairs: Candidates
    """(k,) the objects, each once, and the echo that is most likely its own."""
    echoes: Echoes
    """What each was seen by, (k,): that echo itself, or what stands for several."""
    explained: Mask
    """(m,) the echoes of the image that some object explains."""


def candidates(
    sights: Sight, belief: Belief, echoes: Echoes, clutter: ClutterDensity, settings: EchoSettings
) -> Candidates:
    """Return the pairs that agree by at least one of the object's hypotheses.

    `sights`: what the sonar should see, (h, n) arrays, by the h hypotheses of n objects.
    """
    order = echoes.range_m.argsort()
    in_order = echoes.range_m[order]
    reach = _reach(sights, echoes.table, settings.gate_sigmas)
    first, last = in_order.searchsorted(reach[0]), in_order.searchsorted(reach[1], side="right")
    detected = settings.detection_probability
    return Candidates(
        *_candidates(sights, belief, echoes.table, order, first, last, clutter, settings.gate_sigmas, detected)
    )


@kernel
def _reach(sights: Sight, echoes: Floats, gate: float) -> Floats:
    """Return (2, n) the smallest and the largest range at which an echo may be inside the gate of each object."""
    largest = 0.0
    for j in range(echoes.shape[1]):
        largest = max(largest, echoes[SIGMA_RANGE, j])
    hypotheses, n = sights.range_m.shape
    reach = np.empty((2, n))
    for i in range(n):
        low, high = math.inf, -math.inf
        for h in range(hypotheses):
            # The gate is an ellipse: nothing inside it is farther along the line of sight than `width`.
            width = gate * math.sqrt(sights.along[h, i] + largest**2)
            low, high = min(low, sights.range_m[h, i] - width), max(high, sights.range_m[h, i] + width)
        reach[0, i], reach[1, i] = low, high
    return reach


@kernel
def _candidates(
    sights: Sight,
    belief: Belief,
    echoes: Floats,
    order: Indices,
    first: Indices,
    last: Indices,
    clutter: ClutterDensity,
    gate: float,
    detection_probability: float,
) -> tuple[Indices, Indices, Floats]:
    """Return the fields of `Candidates`. Only the echoes `order[first[i]:last[i]]` may be near object i."""
    most = 0
    for i in range(len(first)):
        most += max(last[i] - first[i], 0)
    objects, columns, evidence = np.empty(most, np.intp), np.empty(most, np.intp), np.empty(most)
    pairs = 0
    for i in range(len(first)):
        for j in order[first[i] : last[i]]:
            if _nearest(sights, echoes, i, j) <= gate**2:
                density = _density(sights, belief.weight, echoes, i, j)
                chance = density * detection_probability / clutter.per_m2[j]
                difference = echoes[RADIUS, j] - belief.radius[i]
                variance = belief.radius_variance[i] + echoes[SIGMA_RADIUS, j] ** 2
                alike = -0.5 * (difference**2 / variance + math.log(2.0 * math.pi * variance))
                objects[pairs], columns[pairs] = i, j
                evidence[pairs] = math.log(max(chance, IMPOSSIBLE)) + max(
                    alike - math.log(clutter.radius[j]), LEAST_RADIUS_EVIDENCE
                )
                pairs += 1
    return objects[:pairs], columns[:pairs], evidence[:pairs]


@kernel
def _nearest(sights: Sight, echoes: Floats, i: int, j: int) -> float:
    """Return the smallest squared distance, in standard deviations, of echo j from a hypothesis of object i."""
    nearest = math.inf
    for h in range(len(sights.range_m)):
        nearest = min(nearest, _distance(sights, echoes, h, i, j)[0])
    return nearest


@kernel
def _density(sights: Sight, weight: Floats, echoes: Floats, i: int, j: int) -> float:
    """Return the probability density, 1/m^2, of the place of echo j if it is of object i."""
    density = 0.0
    for h in range(len(weight)):
        distance, determinant = _distance(sights, echoes, h, i, j)
        density += weight[h, i] * math.exp(-0.5 * distance) / math.sqrt(determinant)
    return density / (2.0 * math.pi)


@kernel
def _distance(sights: Sight, echoes: Floats, h: int, i: int, j: int) -> tuple[float, float]:
    """Return the squared distance, in standard deviations, of echo j from hypothesis h of object i.

    And the determinant, m^4, of the covariance that it is told by.
    """
    horizontal = sights.horizontal[h, i]
    along = echoes[RANGE, j] - sights.range_m[h, i]
    across = wrapped(echoes[BEARING, j] - sights.bearing[h, i]) * horizontal
    s_along = sights.along[h, i] + echoes[SIGMA_RANGE, j] ** 2
    s_across = sights.across[h, i] + (horizontal * echoes[SIGMA_BEARING, j]) ** 2
    s_mixed = sights.mixed[h, i]
    determinant = s_along * s_across - s_mixed**2
    square = s_across * along**2 - 2.0 * s_mixed * along * across + s_along * across**2
    return square / determinant, determinant


def worth_of(found: Candidates, visibility: Floats, detection_probability: float) -> Floats:
    """Return (p,) how much better a pair explains the image than a missed object and a false alarm: log-likelihoods.

    `visibility`: (n,) probability that the object, if it exists, is in view and gives echoes at all just now.
    """
    return _worth(found.objects, found.evidence, visibility, detection_probability)


@kernel
def _worth(objects: Indices, evidence: Floats, visibility: Floats, detection_probability: float) -> Floats:
    worth = np.empty(len(objects))
    for k in range(len(objects)):
        visible = max(visibility[objects[k]], IMPOSSIBLE)
        worth[k] = evidence[k] + math.log(visible) - math.log1p(-detection_probability * visible)
    return worth


def nearest(found: Candidates, worth: Floats, first: Mask, echoes: Echoes, sight: Sight, estimate: Estimate) -> Pairing:
    """Global nearest neighbour: see `registry.Association`; the predictions are not needed again."""
    pairs = associate(found, worth, first, len(echoes))
    explained = np.zeros(len(echoes), bool)
    explained[pairs.echoes] = True
    return Pairing(pairs, echoes.take(pairs.echoes), explained)


def associate(found: Candidates, worth: Floats, first: Mask, echoes: int) -> Candidates:
    """Give each object at most one echo and each echo to at most one object; return the pairs.

    The objects of the mask `first` choose before the others; within each group the sum of worths, all above 0, is the
    largest possible. `echoes`: how many there are.
    """
    chosen, taken = np.zeros(len(worth), bool), np.zeros(echoes, bool)
    for senior in (True, False):
        disputed = _undisputed(found.objects, found.echoes, worth, first, senior, taken, chosen)
        if len(disputed):
            matrix, rows, columns = _matrix(found.objects, found.echoes, worth, disputed, len(first), echoes)
            chosen[disputed] = best_columns(matrix)[rows] == columns
        taken[found.echoes[chosen]] = True
    return found.take(chosen)


@kernel
def _undisputed(
    objects: Indices, echoes: Indices, worth: Floats, first: Mask, senior: bool, taken: Mask, chosen: Mask
) -> Indices:
    """Mark in `chosen` the pairs of the group that have no rival; return those that have.

    The group: objects whose `first` is `senior`, echoes not `taken`, worth above 0.
    """
    of_object, of_echo = np.zeros(len(first), np.intp), np.zeros(len(taken), np.intp)
    group, members = np.empty(len(worth), np.intp), 0
    for k in range(len(worth)):
        if worth[k] > 0.0 and first[objects[k]] == senior and not taken[echoes[k]]:
            of_object[objects[k]] += 1
            of_echo[echoes[k]] += 1
            group[members] = k
            members += 1
    disputed, count = np.empty(members, np.intp), 0
    for k in group[:members]:
        if of_object[objects[k]] == 1 and of_echo[echoes[k]] == 1:
            chosen[k] = True
        else:
            disputed[count] = k
            count += 1
    return disputed[:count]


@kernel
def _matrix(
    objects: Indices, echoes: Indices, worth: Floats, pairs: Indices, all_objects: int, all_echoes: int
) -> tuple[Floats, Indices, Indices]:
    """Return a matrix with the worths of `pairs`, 0 elsewhere, and in which row and column of it each of them is."""
    row_of, column_of = np.full(all_objects, -1), np.full(all_echoes, -1)
    rows, columns = np.empty(len(pairs), np.intp), np.empty(len(pairs), np.intp)
    height = width = 0
    for p, k in enumerate(pairs):
        if row_of[objects[k]] < 0:
            row_of[objects[k]] = height
            height += 1
        if column_of[echoes[k]] < 0:
            column_of[echoes[k]] = width
            width += 1
        rows[p], columns[p] = row_of[objects[k]], column_of[echoes[k]]
    matrix = np.zeros((height, width))
    for p, k in enumerate(pairs):
        matrix[rows[p], columns[p]] = worth[k]
    return matrix, rows, columns
