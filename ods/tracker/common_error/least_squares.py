"""Least squares over the positions of static objects, with a fading memory.

Each object has unknowns of its own (its place, its near edge, its depth), which are eliminated; what is left are the
errors that all have in common. Standard errors come from leaving out one object at a time (jackknife; Efron, 1982): the
errors of one object's echoes go together, those of two objects do not, and a mover makes them large.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.tracker.common_error.sightings import COLUMNS, EAST, NORTH, OWN, TURN, YAW, Sightings

NEARER_SIGMA_M, DEPTH_SIGMA_M = 2.0, 3.0
"""Of what is not known of an object: its half thickness, and by how much it lies deeper or higher than the head."""
LEAST_MEMORY = 7.0
"""Of pings, where they come so seldom that a memory in seconds would hold fewer."""
SEEN_LEAST = 3.0
"""Sightings of an object, those that fade counted in part, below which it shows nothing;"""
FORGOTTEN = 0.5
"""and below which it is forgotten."""
WHOLE = COLUMNS + 1
OWN_INFORMATION = np.diag([1e-8, 1e-8, NEARER_SIGMA_M**-2, DEPTH_SIGMA_M**-4])


class Reduced(NamedTuple):
    """n objects, their own unknowns eliminated."""

    information: Floats
    """(n, 7, 7): of the errors in common and, last, of the places seen."""
    freedom: Floats
    """(n,) of their residuals."""

    def without(self, which: int) -> "Reduced":
        """Return all but one object."""
        return Reduced(np.delete(self.information, which, axis=0), np.delete(self.freedom, which))


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
        order = np.argsort(self._id)
        rows = order[np.searchsorted(self._id, seen.id, sorter=order)]
        moved = (seen.place - self._first[rows])[:, :, None]
        equations = seen.whitening @ np.concatenate([seen.design, moved], axis=2)
        self._sums[rows] += equations.swapaxes(1, 2) @ equations
        self._seen[rows] += 1.0

    def _fade(self, seconds: float) -> None:
        """Let what was seen count less, and rates count from `seconds` later."""
        fade = math.exp(-min(seconds / self._memory_s, 1.0 / LEAST_MEMORY))
        later = np.eye(WHOLE)
        later[YAW, TURN] = later[0, NORTH] = later[1, EAST] = -seconds
        kept = self._seen * fade > FORGOTTEN
        self._id, self._first, self._seen = self._id[kept], self._first[kept], self._seen[kept] * fade
        self._sums = fade * (later.T @ self._sums[kept] @ later)

    def _begin(self, seen: Sightings) -> None:
        new = ~np.isin(seen.id, self._id)
        count = int(np.count_nonzero(new))
        self._id, self._first = np.append(self._id, seen.id[new]), np.append(self._first, seen.place[new], axis=0)
        self._sums, self._seen = (
            np.append(self._sums, np.zeros((count, WHOLE, WHOLE)), axis=0),
            np.append(self._seen, np.zeros(count)),
        )

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
    columns = [column - OWN for column in errors]
    each, right = reduced.information[:, columns][:, :, columns], reduced.information[:, columns, -1]
    together, wanted = each.sum(axis=0), right.sum(axis=0)
    try:
        covariance = np.linalg.inv(together)
        value = covariance @ wanted
        left_out = np.linalg.solve(together - each, (wanted - right)[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        return None
    count = len(each)
    few = count / (count - 2)
    jackknife = few * (count - 1) / count * ((left_out - value) ** 2).sum(axis=0)
    left = _mean_squares(reduced, columns, value[None], np.ones((1, count)))[0]
    variance = max(1.0, float(left)) * np.diag(covariance) + jackknife
    if not (np.isfinite(variance).all() and (variance > 0.0).all() and np.isfinite(value).all()):
        return None
    left_without = _mean_squares(reduced, columns, left_out, 1.0 - np.eye(count))
    return Fit(value, np.sqrt(variance), float(wanted @ value), float(left), left_without)


def _mean_squares(reduced: Reduced, columns: list[int], values: Floats, counted: Floats) -> Floats:
    """Return (k,) the mean square that (k, p) values leave of the objects that count, (k, n) of 0 and 1."""
    each, right = reduced.information[:, columns][:, :, columns], reduced.information[:, columns, -1]
    rest = reduced.information[:, -1, -1] - 2.0 * values @ right.T + np.einsum("ki,nij,kj->kn", values, each, values)
    return np.asarray((counted * rest).sum(axis=1) / (counted @ reduced.freedom))
