"""Least squares over the positions of static objects, with a fading memory.

Each object has unknowns of its own (its place, its near edge, its depth), which are eliminated; what is left are the
errors that all have in common. Standard errors come from leaving out one object at a time (jackknife; Efron, 1982): the
errors of one object's echoes go together, those of two objects do not, and a mover makes them large.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.compiled import native
from ods.tracker.common_error.sightings import (
    EAST,
    EAST_OF_OBJECT,
    NORTH,
    NORTH_OF_OBJECT,
    OWN,
    SCALE,
    TURN,
    WHOLE,
    YAW,
    Sightings,
)

FAST_MEMORY_S, SLOW_MEMORY_S = 1.0, 60.0
"""A short memory finds a fast drift soon, a long one finds what is slow or small."""
PLACE_SIGMA_M, NEARER_SIGMA_M, DEPTH_SIGMA_M = 1e4, 2.0, 3.0
"""Of what is not known of an object: its place, its half thickness, and by how much it lies deeper or higher than the
head."""
LEAST_MEMORY = 7.0
"""Of pings, where they come so seldom that a memory in seconds would hold fewer."""
SEEN_LEAST = 3.0
"""Sightings of an object, those that fade counted in part, below which it shows nothing;"""
FORGOTTEN = 0.5
"""and below which it is forgotten."""
RATES = np.array([YAW, NORTH_OF_OBJECT, EAST_OF_OBJECT]), np.array([TURN, NORTH, EAST])
"""Columns of what changes with time, and of its rates."""
OWN_INFORMATION = np.diag(np.reciprocal(np.square([PLACE_SIGMA_M, PLACE_SIGMA_M, NEARER_SIGMA_M, DEPTH_SIGMA_M**2])))


class Reduced(NamedTuple):
    """n objects, their own unknowns eliminated."""

    information: Floats
    """(n, 7, 7): of the errors in common and, last, of the places seen."""
    freedom: Floats
    """(n,) of their residuals."""

    def without(self, which: int) -> "Reduced":
        """Return all but one object."""
        return Reduced(np.delete(self.information, which, axis=0), np.delete(self.freedom, which))

    def turned(self, yaw: float) -> "Reduced":
        """Return the same with the sine of an error of the yaw, about that large, rad, in the place of the angle.

        It moves a place by sin(yaw) of its distance across, and by 1 - cos(yaw) nearer: as ranges too short by that
        share. So the equations are exact for a large angle, too.
        """
        information, scale = self.information.copy(), -math.tan(0.5 * yaw)
        information[:, YAW - OWN] += scale * information[:, SCALE - OWN]
        information[:, :, YAW - OWN] += scale * information[:, :, SCALE - OWN]
        return Reduced(information, self.freedom)


class Fit(NamedTuple):
    """Some errors, all others taken to be 0."""

    value: Floats
    sigma: Floats
    gain: float
    """By how much the sum of squared residuals is smaller with them;"""
    left: float
    """what is left of it, as a mean square;"""
    left_without: Floats
    """(n,) and the same if one object is left out."""


class FadingSums:
    """The normal equations of each object seen lately."""

    def __init__(self, memory_s: float) -> None:
        """What was seen `memory_s` ago counts 1 / e."""
        self._memory_s, self._t_s = memory_s, 0.0
        self._id: Ints = np.zeros(0, np.int64)
        self._first: Floats = np.zeros((0, 2))
        """(n, 2) places from which each object's are counted,"""
        self._sums: Floats = np.zeros((0, WHOLE, WHOLE))
        self._seen: Floats = np.zeros(0)

    def add(self, seen: Sightings, t_s: float) -> None:
        """Take in what a ping showed at `t_s`."""
        self._fade(t_s - self._t_s)
        self._t_s = t_s
        self._begin(seen)
        rows = {each: row for row, each in enumerate(self._id.tolist())}
        of = np.array([rows[each] for each in seen.id.tolist()], np.int64)
        native.add_sightings(seen.place, seen.design, seen.whitening, of, self._first, self._sums, self._seen)

    def first_places(self, seen: Sightings) -> Floats:
        """Return (k, 2) where the objects were when first seen."""
        rows = {each: row for row, each in enumerate(self._id.tolist())}
        places = seen.place.copy()
        for k, each in enumerate(seen.id.tolist()):
            if each in rows:
                places[k] = self._first[rows[each]]
        return places

    def _fade(self, seconds: float) -> None:
        """Let what was seen count less, and rates count from `seconds` later."""
        fade = math.exp(-min(seconds / self._memory_s, 1.0 / LEAST_MEMORY))
        kept = self._seen * fade > FORGOTTEN
        if not kept.all():
            self._id, self._first, self._seen = self._id[kept], self._first[kept], self._seen[kept]
            self._sums = self._sums[kept]
        self._seen *= fade
        native.fade_sums(self._sums, fade, seconds, *RATES)

    def _begin(self, seen: Sightings) -> None:
        known = set(self._id.tolist())
        new = [k for k, each in enumerate(seen.id.tolist()) if each not in known]
        if new:
            self._id, self._first = np.append(self._id, seen.id[new]), np.append(self._first, seen.place[new], axis=0)
            self._sums = np.append(self._sums, np.zeros((len(new), WHOLE, WHOLE)), axis=0)
            self._seen = np.append(self._seen, np.zeros(len(new)))

    def reduced(self) -> Reduced:
        """Return the estimate of the common errors by the objects."""
        enough = self._seen > SEEN_LEAST
        sums = self._sums[enough]
        own, mixed = sums[:, :OWN, :OWN] + OWN_INFORMATION, sums[:, :OWN, OWN:]
        rest = sums[:, OWN:, OWN:] - mixed.swapaxes(1, 2) @ np.linalg.solve(own, mixed)
        return Reduced(rest, np.maximum(2.0 * self._seen[enough] - OWN, 1.0))


def fit(reduced: Reduced, errors: tuple[int, ...]) -> Fit | None:
    """Return the best values of the errors of some columns; None where they cannot be distinguished. Three objects or
    more.

    The variance that few objects show is itself uncertain, and grows as that of Student's distribution.
    """
    columns = np.array(errors, np.int64) - OWN
    count, size = len(reduced.freedom), len(errors)
    value, covariance, changes, left = np.empty(size), np.empty(size), np.empty(size), np.empty(count + 1)
    if not native.fit_errors(reduced, columns, value, covariance, changes, left):
        return None
    jackknife = (count - 1) / (count - 2) * changes
    variance = max(1.0, float(left[0])) * covariance + jackknife
    if not (np.isfinite(variance).all() and (variance > 0.0).all() and np.isfinite(value).all()):
        return None
    wanted = reduced.information[:, columns, -1].sum(axis=0)
    return Fit(value, np.sqrt(variance), float(wanted @ value), float(left[0]), left[1:])
