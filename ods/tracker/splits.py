"""Where echoes and objects are not one to one: several echoes of a large object, one echo of two close objects."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array, wrap_angle
from ods.tracker.association import Candidates
from ods.tracker.belief import Estimate
from ods.tracker.measurement import Sight
from ods.tracker.scan import Echoes

Rows = NDArray[np.intp]
Mask = NDArray[np.bool_]

PART_SHARE = 0.5
"""The middle of the parts of a large object that are seen lies off its centre by about this share of its radius."""
SMALLEST_OFFSET_M = 1e-3
"""The echo of two objects at one place is off the centre of each by at least this."""


@dataclass(frozen=True, slots=True)
class Parts:
    """Objects of which only parts were seen: (k,) each."""

    objects: Rows
    evidence: Array
    """Of the strongest of its echoes."""
    echoes: Echoes
    """The middle of all its echoes."""
    variance: Array
    """Of the distance between that middle and the object's centre, m^2."""


def parts_inside(sight: Sight, radius: Array, echoes: Echoes, objects: Rows, loose: Rows) -> tuple[Rows, Rows]:
    """Find the `loose` echoes that are inside the circle of one of `objects`.

    `sight`: (n,) arrays; `radius`: (n,). Returns pairs of the object, that whose circle the echo is deepest in, and
    the echo; an object may come more than once.
    """
    if not len(objects) or not len(loose):
        nothing = np.zeros(0, np.intp)
        return nothing, nothing
    along = echoes.range_m[loose][None, :] - sight.range_m[objects][:, None]
    turn = wrap_angle(echoes.bearing[loose][None, :] - sight.bearing[objects][:, None])
    excess = np.hypot(along, turn * sight.horizontal[objects][:, None]) - radius[objects][:, None]
    deepest = np.argmin(excess, axis=0)
    inside = excess[deepest, np.arange(len(loose))] < 0.0
    return objects[deepest[inside]], loose[inside]


def put_together(pairs: Candidates, echoes: Echoes, radius: Array) -> Parts:
    """Put the echoes of each object of `pairs` together; `radius`: of all objects."""
    wholes, first, group = np.unique(pairs.objects, return_index=True, return_inverse=True)
    count = np.bincount(group)
    middle = replace(
        echoes.take(pairs.echoes[first]),
        range_m=np.bincount(group, echoes.range_m[pairs.echoes]) / count,
        bearing=np.bincount(group, echoes.bearing[pairs.echoes]) / count,
    )
    evidence = np.full(len(wholes), -np.inf)
    np.maximum.at(evidence, group, pairs.evidence)
    return Parts(wholes, evidence, middle, (PART_SHARE * radius[wholes]) ** 2)


def merged(estimate: Estimate, hit: Mask, here: Mask) -> Array:
    """Return (n,) variance, m^2, by which an echo may lie off its object's centre because it is of two objects.

    Where the circles of two objects touch and only one of them is `hit`, its echo may be the echo of both; `here`:
    objects that the sonar looks at. 0: no such neighbour.
    """
    result = np.zeros(len(hit))
    seen, unseen = (here & hit).nonzero()[0], (here & ~hit).nonzero()[0]
    if not len(seen) or not len(unseen):
        return result
    offset = estimate.position[:2, seen][:, :, None] - estimate.position[:2, unseen][:, None, :]
    separation = np.hypot(offset[0], offset[1])
    touching = separation < estimate.radius[seen][:, None] + estimate.radius[unseen]
    half = np.where(touching, np.maximum(0.5 * separation, SMALLEST_OFFSET_M), 0.0) ** 2
    result[seen], result[unseen] = half.max(axis=1), half.max(axis=0)
    return result
