"""Which echoes may be whose: the statistical gate, and how well each pair inside it explains the image.

Everything is compared in the sonar's own coordinates, along and across the line of sight, where range and bearing
noise keep their shape; the uncertainty of prediction and pose is part of it.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled.kernel import kernel
from ods.tracker.association.clutter import ClutterDensity
from ods.tracker.measurement.cut_off import farthest_off
from ods.tracker.measurement.model import PredictedMeasurement, predicted_rows, wrapped
from ods.tracker.measurement.scan import Echoes, EchoRows, echo_rows
from ods.tracker.named import Named
from ods.tracker.observer.belief import Belief

IMPOSSIBLE = 1e-300
"""Keeps the logarithm of a likelihood that is too small for a number finite."""
LEAST_RADIUS_RATIO = -4.5
"""A radius that does not agree never counts for more than a 3-sigma difference: echoes merge, split and change."""


class Hypotheses(NamedTuple):
    """Pairs of an object and an echo that may be its own: (p,) each."""

    objects: Indices
    echoes: Indices
    llr: Floats
    """Log-likelihood ratio: the echo is of this object, or a false alarm."""
    score: Floats
    """Log-likelihood ratio: this pair, or a missed object and a false alarm."""

    def take(self, chosen: Mask) -> "Hypotheses":
        """Return the pairs of a mask."""
        rows = chosen.nonzero()[0]
        return Hypotheses(self.objects.take(rows), self.echoes.take(rows), self.llr.take(rows), self.score.take(rows))

    def joined(self, other: "Hypotheses") -> "Hypotheses":
        """Return the pairs of both."""
        if not len(other.objects):
            return self
        return Hypotheses(
            np.concatenate([self.objects, other.objects]),
            np.concatenate([self.echoes, other.echoes]),
            np.concatenate([self.llr, other.llr]),
            np.concatenate([self.score, other.score]),
        )


class Detectability(NamedTuple):
    """What is expected of n objects before the image is looked at."""

    visibility: Floats
    """(n,) probability that the object, if it exists, is in view and gives echoes at all just now."""
    detection_probability: float
    """That it then has one in this image."""


class _Gate(NamedTuple):
    sigmas: float
    detection_probability: float


def hypotheses(
    predicted: Named[PredictedMeasurement],
    belief: Belief,
    echoes: Echoes,
    clutter: ClutterDensity,
    chance: Detectability,
    gate_sigmas: float,
) -> Hypotheses:
    """Return the pairs that agree by at least one of the object's hypotheses of motion.

    `predicted`: what the sonar should see, (h, n) arrays, by the h hypotheses of `belief`.
    """
    order = echoes.rows.range_m.argsort()
    gate = _Gate(gate_sigmas, chance.detection_probability)
    extent = belief.weight, belief.radius, belief.radius_variance
    return scored(*_gated(predicted.table, extent, echoes.table, clutter, order, gate), chance)


def scored(objects: Indices, echoes: Indices, llr: Floats, chance: Detectability) -> Hypotheses:
    """Return pairs with their scores."""
    return Hypotheses(objects, echoes, llr, _score(objects, llr, chance.visibility, chance.detection_probability))


@kernel
def _score(objects: Indices, llr: Floats, visibility: Floats, detection_probability: float) -> Floats:
    score = np.empty(len(objects))
    for k in range(len(objects)):
        visible = max(visibility[objects[k]], IMPOSSIBLE)
        score[k] = llr[k] + math.log(visible) - math.log1p(-detection_probability * visible)
    return score


@kernel
def _windows(predicted: PredictedMeasurement, echoes: EchoRows, order: Indices, gate: float) -> Indices:
    """Return (2, n): only the echoes `order[first:last]` may be inside the gate of an object."""
    largest = 0.0
    for sigma in echoes.sigma_range:
        largest = max(largest, sigma)
    hypotheses, n = predicted.range_m.shape
    in_order, windows = echoes.range_m[order], np.empty((2, n), np.intp)
    for i in range(n):
        low, high = math.inf, -math.inf
        for h in range(hypotheses):
            # The gate is an ellipse: nothing inside it is farther along the line of sight than `width`.
            width = gate * math.sqrt(predicted.along[h, i] + largest**2)
            low, high = min(low, predicted.range_m[h, i] - width), max(high, predicted.range_m[h, i] + width)
        windows[0, i] = np.searchsorted(in_order, low)
        windows[1, i] = np.searchsorted(in_order, high, side="right")
    return windows


@kernel
def _gated(
    predicted_table: Floats,
    extent: tuple[Floats, Floats, Floats],
    echo_table: Floats,
    clutter: ClutterDensity,
    order: Indices,
    gate: _Gate,
) -> tuple[Indices, Indices, Floats]:
    """Return objects, echoes and log-likelihood ratios of `Hypotheses`.

    `extent`: weight, radius and radius_variance of `Belief`; `order`: of the echoes by range.
    """
    predicted, echoes = predicted_rows(predicted_table), echo_rows(echo_table)
    weight, radius, radius_variance = extent
    first, last = _windows(predicted, echoes, order, gate.sigmas)
    count = 0
    for i in range(len(first)):
        count += max(last[i] - first[i], 0)
    objects, columns, llr = np.empty(count, np.intp), np.empty(count, np.intp), np.empty(count)
    pairs = 0
    for i in range(len(first)):
        for j in order[first[i] : last[i]]:
            most = farthest_off(echoes.cut[j], radius[i], radius_variance[i])
            if _nearest(predicted, echoes, most, i, j) <= gate.sigmas**2:
                density = _density(predicted, weight, echoes, most, i, j)
                chance = density * gate.detection_probability / clutter.per_m2[j]
                difference = echoes.radius[j] - radius[i]
                variance = radius_variance[i] + echoes.sigma_radius[j] ** 2
                alike = -0.5 * (difference**2 / variance + math.log(2.0 * math.pi * variance))
                objects[pairs], columns[pairs] = i, j
                llr[pairs] = math.log(max(chance, IMPOSSIBLE)) + max(
                    alike - math.log(clutter.radius[j]), LEAST_RADIUS_RATIO
                )
                pairs += 1
    return objects[:pairs], columns[:pairs], llr[:pairs]


@kernel
def _nearest(predicted: PredictedMeasurement, echoes: EchoRows, most: float, i: int, j: int) -> float:
    """Return the smallest squared distance, in standard deviations, of echo j from a hypothesis of object i.

    `most`: largest variance that the echo's place can have, m^2.
    """
    nearest = math.inf
    for h in range(len(predicted.range_m)):
        nearest = min(nearest, _distance(predicted, echoes, most, h, i, j)[0])
    return nearest


@kernel
def _density(predicted: PredictedMeasurement, weight: Floats, echoes: EchoRows, most: float, i: int, j: int) -> float:
    """Return the probability density, 1/m^2, of the place of echo j if it is of object i; `most`: as in `_nearest`."""
    density = 0.0
    for h in range(len(weight)):
        distance, determinant = _distance(predicted, echoes, most, h, i, j)
        density += weight[h, i] * math.exp(-0.5 * distance) / math.sqrt(determinant)
    return density / (2.0 * math.pi)


@kernel
def _distance(
    predicted: PredictedMeasurement, echoes: EchoRows, most: float, h: int, i: int, j: int
) -> tuple[float, float]:
    """Return the squared distance, in standard deviations, of echo j from hypothesis h of object i.

    And the determinant, m^4, of the covariance that it is told by. `most`: as in `_nearest`.
    """
    horizontal = predicted.horizontal[h, i]
    along = echoes.range_m[j] - predicted.range_m[h, i]
    across = wrapped(echoes.bearing[j] - predicted.bearing[h, i]) * horizontal
    s_along = predicted.along[h, i] + min(echoes.sigma_range[j] ** 2, most)
    s_across = predicted.across[h, i] + min((horizontal * echoes.sigma_bearing[j]) ** 2, most)
    s_mixed = predicted.mixed[h, i]
    determinant = s_along * s_across - s_mixed**2
    square = s_across * along**2 - 2.0 * s_mixed * along * across + s_along * across**2
    return square / determinant, determinant
