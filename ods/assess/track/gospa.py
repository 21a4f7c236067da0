"""Generalised optimal sub-pattern assignment: how far a set of tracks is from the objects that there are.

Rahmathullah, Garcia-Fernandez, Svensson: Generalized optimal sub-pattern assignment metric, FUSION 2017; alpha = 2.
"""

from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats, Indices

CUTOFF_M = 10.0
ORDER = 2.0


@dataclass(frozen=True)
class Pairs:
    """The best assignment of tracks to objects."""

    objects: Indices
    tracks: Indices
    distance: Floats
    """(pairs,) m, below the cutoff."""


def pair(distance: Floats, cutoff: float = CUTOFF_M, order: float = ORDER) -> Pairs:
    """Return the assignment that minimises GOSPA for (objects, tracks) distances: pairs at the cutoff are left out."""
    from scipy.optimize import linear_sum_assignment  # 20 MB: only where lists are judged

    rows, columns = linear_sum_assignment(np.minimum(distance, cutoff) ** order)
    near = distance[rows, columns] < cutoff
    rows, columns = rows[near], columns[near]
    return Pairs(rows, columns, distance[rows, columns])


def gospa(distance: Floats, missed: int, false: int, cutoff: float = CUTOFF_M, order: float = ORDER) -> float:
    """Return the metric, m, of (pairs,) distances, and how many objects and tracks have no partner."""
    alone = 0.5 * cutoff**order * (missed + false)
    return float((np.sum(distance**order) + alone) ** (1.0 / order))
