"""Two tracks of one object: a young one continues a silent old one, or a silent one is part of a larger object."""

import numpy as np

from ods.base.arrays import Indices
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
