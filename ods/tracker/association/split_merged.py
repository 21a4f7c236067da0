"""Where echoes and objects are not one to one: several echoes of a large object, one echo of two close objects."""

import math
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.base.kernel import kernel
from ods.tracker.association.gnn import Candidates
from ods.tracker.measurement.model import Sight, wrapped
from ods.tracker.measurement.scan import BEARING, RANGE, Echoes
from ods.tracker.observer.belief import Estimate

PART_SHARE = 0.5
"""The middle of the parts of a large object that are seen lies off its centre by about this share of its radius."""
SMALLEST_OFFSET_M = 1e-3
"""The echo of two objects at one place is off the centre of each by at least this."""


@dataclass(frozen=True, slots=True)
class Parts:
    """Objects of which only parts were seen: (k,) each."""

    objects: Indices
    evidence: Floats
    """Of the strongest of its echoes."""
    echoes: Echoes
    """The middle of all its echoes."""
    variance: Floats
    """Of the distance between that middle and the object's centre, m^2."""


def parts_inside(
    sight: Sight, radius: Floats, echoes: Echoes, objects: Indices, loose: Indices
) -> tuple[Indices, Indices]:
    """Find the `loose` echoes that are inside the circle of one of `objects`.

    `sight`: (n,) arrays; `radius`: (n,). Returns pairs of the object, that whose circle the echo is deepest in, and
    the echo; an object may come more than once.
    """
    return _parts_inside(sight, radius, echoes.table, objects, loose)


@kernel
def _parts_inside(
    sight: Sight, radius: Floats, echoes: Floats, objects: Indices, loose: Indices
) -> tuple[Indices, Indices]:
    wholes, parts, found = np.empty(len(loose), np.intp), np.empty(len(loose), np.intp), 0
    for j in loose:
        deepest, whole = 0.0, -1
        for i in objects:
            along = echoes[RANGE, j] - sight.range_m[i]
            if abs(along) < radius[i]:
                across = wrapped(echoes[BEARING, j] - sight.bearing[i]) * sight.horizontal[i]
                excess = math.hypot(along, across) - radius[i]
                if excess < deepest:
                    deepest, whole = excess, i
        if whole >= 0:
            wholes[found], parts[found] = whole, j
            found += 1
    return wholes[:found], parts[:found]


def put_together(pairs: Candidates, echoes: Echoes, radius: Floats) -> Parts:
    """Put the echoes of each object of `pairs` together; `radius`: of all objects."""
    wholes, evidence, middle = _put_together(pairs, echoes.table, len(radius))
    return Parts(wholes, evidence, Echoes(middle), (PART_SHARE * radius[wholes]) ** 2)


@kernel
def _put_together(pairs: Candidates, echoes: Floats, all_objects: int) -> tuple[Indices, Floats, Floats]:
    """Return objects (k,), evidence (k,) and middle echoes (7, k), of `echoes` (7, m)."""
    place, k = np.full(all_objects, -1), 0
    count = np.zeros(len(pairs.objects))
    wholes, evidence = np.empty(len(count), np.intp), np.empty(len(count))
    middle = np.empty((echoes.shape[0], len(count)))
    for pair, i in enumerate(pairs.objects):
        j = pairs.echoes[pair]
        if place[i] < 0:
            place[i], wholes[k], evidence[k] = k, i, pairs.evidence[pair]
            middle[:, k] = echoes[:, j]
            k += 1
        else:
            evidence[place[i]] = max(evidence[place[i]], pairs.evidence[pair])
            middle[RANGE, place[i]] += echoes[RANGE, j]
            middle[BEARING, place[i]] += echoes[BEARING, j]
        count[place[i]] += 1.0
    middle[RANGE] /= count
    middle[BEARING] /= count
    return wholes[:k], evidence[:k], middle[:, :k].copy()


def merged(estimate: Estimate, hit: Mask, here: Mask) -> Floats:
    """Return (n,) variance, m^2, by which an echo may lie off its object's centre because it is of two objects.

    Where the circles of two objects touch and only one of them is `hit`, its echo may be the echo of both; `here`:
    objects that the sonar looks at. 0: no such neighbour.
    """
    return _merged(estimate, (here & hit).nonzero()[0], (here & ~hit).nonzero()[0])


@kernel
def _merged(estimate: Estimate, seen: Indices, unseen: Indices) -> Floats:
    result = np.zeros(len(estimate.radius))
    for i in seen:
        for j in unseen:
            north = estimate.position[0, i] - estimate.position[0, j]
            reach = estimate.radius[i] + estimate.radius[j]
            if abs(north) < reach:
                separation = math.hypot(north, estimate.position[1, i] - estimate.position[1, j])
                if separation < reach:
                    half = max(0.5 * separation, SMALLEST_OFFSET_M) ** 2
                    result[i], result[j] = max(result[i], half), max(result[j], half)
    return result
