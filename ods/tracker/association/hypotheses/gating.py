"""Gating: the possible pairs of object and echo, and how well each pair explains the image.

Everything is compared in the sonar's own coordinates, along and across the line of sight, where range and bearing
noise keep their shape; the uncertainty of prediction and pose is part of it.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled import native
from ods.tracker.association.hypotheses.clutter import ClutterDensity
from ods.tracker.measurement.model import PredictedMeasurement
from ods.tracker.measurement.scan import Echoes
from ods.tracker.named import Named
from ods.tracker.observer.belief import Belief

ROOM = 8
"""Initial capacity for pairs per object and echo."""


class Hypotheses(NamedTuple):
    """Pairs of an object and an echo that may be its own: (p,) each."""

    objects: Indices
    echoes: Indices
    llr: Floats
    """Log-likelihood ratio: the echo is of this object, or a false alarm."""
    score: Floats
    """Log-likelihood ratio: this pair, or a missed object and a false alarm."""

    def plain(self) -> "Hypotheses":
        """Return the pairs as kernels take them, whoever made them."""
        objects, echoes = np.ascontiguousarray(self.objects, np.intp), np.ascontiguousarray(self.echoes, np.intp)
        return Hypotheses(objects, echoes, np.ascontiguousarray(self.llr), np.ascontiguousarray(self.score))

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
    """Expectations of n objects before the image is used."""

    visibility: Floats
    """(n,) probability that the object, if it exists, is in view and gives echoes at all just now."""
    detection_probability: float
    """That it then has one in this image."""


def hypotheses(
    predicted: Named[PredictedMeasurement],
    belief: Belief,
    echoes: Echoes,
    clutter: ClutterDensity,
    chance: Detectability,
    gate_sigmas: float,
    left_out: Mask | None = None,
) -> Hypotheses:
    """Return the pairs that agree by at least one of the object's hypotheses of motion.

    `predicted`: what the sonar should see, (h, n) arrays, by the h hypotheses of `belief`; `left_out`: (n,) objects of
    which no pair is wanted.
    """
    objects, m = len(belief.radius), len(clutter.radius)
    if left_out is None:
        left_out = np.zeros(objects, np.bool_)
    extent = belief.weight, belief.radius, belief.radius_variance
    asked = predicted.table, extent, echoes.table, (clutter.per_m2, clutter.radius), chance.visibility, left_out
    gate, room = (gate_sigmas, chance.detection_probability), ROOM * (objects + m)
    while True:
        found = Hypotheses(*np.empty((2, room), np.intp), *np.empty((2, room)))
        count = native.gating_pairs(asked, gate, found)
        if count <= room:
            return Hypotheses(found.objects[:count], found.echoes[:count], found.llr[:count], found.score[:count])
        room = count
