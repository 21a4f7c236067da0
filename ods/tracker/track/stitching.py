"""Two tracks of one object: a young one continues a silent old one, or a silent one is part of a larger object."""

import math

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled.kernel import kernel
from ods.tracker.linear_assignment import best_columns
from ods.tracker.observer.belief import Estimate
from ods.tracker.track.tracks import History

FARTHEST_M = 10.0
"""However uncertain its prediction, an object is not found again farther away than this."""


def stitch(
    history: History, estimate: Estimate, young: Indices, old: Indices, gate_sigmas: float
) -> tuple[Indices, Indices]:
    """Find which of `young` are objects of `old` seen again.

    They agree in place within the gate, and the old one was last seen before the young one's first echo, so that no
    image ever showed both. Returns the pairs, each object at most once.
    """
    nothing = np.zeros(0, np.intp)
    if not len(young) or not len(old):
        return nothing, nothing
    north, east = (estimate.position[axis, young][:, None] - estimate.position[axis, old][None, :] for axis in (0, 1))
    s_nn, s_ee = (estimate.variance[axis, young][:, None] + estimate.variance[axis, old][None, :] for axis in (0, 1))
    s_ne = estimate.covariance_ne[young][:, None] + estimate.covariance_ne[old][None, :]
    distance = (s_ee * north**2 - 2.0 * s_ne * north * east + s_nn * east**2) / (s_nn * s_ee - s_ne**2)
    possible = (distance < gate_sigmas**2) & (np.hypot(north, east) < FARTHEST_M)
    possible &= history.last[old][None, :] < history.born[young][:, None]
    if not possible.any():
        return nothing, nothing
    gain = np.where(possible, gate_sigmas**2 - distance, 0.0)
    columns = best_columns(gain)
    real = (columns >= 0) & (gain[np.arange(len(gain)), columns] > 0.0)
    return young[real], old[columns[real]]


@kernel
def is_duplicate(i: int, missed: Mask, history: History, position: Floats, radius: Floats) -> bool:
    """Tell whether young object i may be stray echoes of one of the `missed`, (n,) objects not seen in this image.

    Their circles touch, and the old one was seen since the young one began, so that the young one does not continue it:
    until an image shows both, they are one.
    """
    found = False
    for j in range(len(missed)):
        if missed[j] and history.last[j] >= history.born[i]:
            found |= _apart(position, i, j) < radius[i] + radius[j]
    return found


@kernel
def is_covered(i: int, others: Mask, position: Floats, radius: Floats) -> bool:
    """Tell whether object i lies inside the circle of one of the `others`, (n,)."""
    found = False
    for j in range(len(others)):
        found |= others[j] and _apart(position, i, j) < radius[j]
    return found


@kernel
def _apart(position: Floats, i: int, j: int) -> float:
    """Return the horizontal distance of two objects."""
    return math.hypot(position[0, i] - position[0, j], position[1, i] - position[1, j])
