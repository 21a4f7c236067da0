"""The outlines and near edges of the confirmed objects: what the last images showed of each, beside the filters.

The extent is the mean matrix of second moments, as in tracking by random matrices (Koch, 2008, IEEE Transactions on
Aerospace and Electronic Systems 44(3)), without its weighing: what limits it is which part of a body shines, not noise.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Ints
from ods.base.clock import NS
from ods.messages import Outline
from ods.runtime.pose_buffer import PoseEstimate
from ods.tracker.named import Named
from ods.tracker.outline.seen import Seen
from ods.tracker.output.snapshot import Snapshot

NEWEST_SHARE = 0.1
"""Least weight of the newest image in the means."""
GATE_SIGMAS, GATE_M = 3.0, 0.5
"""An echo is of the object whose edge is nearest to its middle, and at most so far away."""
UNSEEN_S = 2.0
"""What was not seen for longer has no near edge any more: which side of it is the nearest may have changed."""
SIDE_CHANGES = 0.1
"""Standard deviation of what a near edge may change by as another side comes into view, m in a second."""
ELONGATED_M, ELONGATED = 1.5, 2.5
"""An object is elongated from this half length on, and from so many times its half width."""
LEAST_SIGHTS = 3
"""Images that an outline takes."""
LENGTH_ERROR = 0.05
"""Part of a length that no image tells: ends that do not shine."""


class Known(NamedTuple):
    """What is known of n objects: (n,) each."""

    sights: Floats
    """Images in which they were seen."""
    seen_s: Floats
    """Time since the newest of these, s."""
    near: Floats
    """Slant range of the near edge from the head, m;"""
    near_variance: Floats
    """its variance, m^2, and"""
    near_claim: Floats
    """the mean of the variances that the images claim, m^2."""
    north: Floats
    """From the object's place to the outline's middle, m,"""
    east: Floats
    nn: Floats
    """Second moments, m^2: north, both, east."""
    ne: Floats
    ee: Floats
    length: Floats
    """Mean of the images' half lengths, m, and"""
    length_square: Floats
    """of their squares, m^2."""


class Outlines:
    """What is known of the confirmed objects, by their ids."""

    def __init__(self) -> None:
        self._ids: Ints = np.empty(0, np.int64)
        self._known = Named(Known, np.empty((len(Known._fields), 0)))
        self._t_ns = 0

    def look(self, snapshot: Snapshot, seen: Seen, head: PoseEstimate, t_ns: int) -> None:
        """Take in the echoes of an image: those inside an object, or about it, show its outline."""
        self._follow(snapshot, head, t_ns)
        objects, echoes = _owned(snapshot, seen)
        if not len(objects):
            return
        rows, parts = np.unique(objects, return_inverse=True)
        sums = _Sums(parts, len(rows))
        weight = np.maximum(seen.length[echoes], 1e-3)
        total = sums.of(weight)
        place = seen.place[echoes]
        middle = np.stack([sums.of(weight * axis) / total for axis in place.T])
        apart = place - middle.T[parts]
        moments = seen.extent[echoes] + apart[:, :, None] * apart[:, None, :]
        nn, ne, ee = (sums.of(weight * moments[:, i, j]) / total for i, j in ((0, 0), (0, 1), (1, 1)))
        first = np.lexsort((seen.near[echoes], parts))[np.concatenate([[0], np.cumsum(np.bincount(parts))[:-1]])]
        self._near(rows, seen.near[echoes][first], seen.sigma_near[echoes][first] ** 2)
        half = np.sqrt(3.0 * _largest(nn, ne, ee))
        offset = middle - snapshot.position[:2, rows]
        self._mean(rows, (*offset, nn, ne, ee, half, half**2))

    def near_edges(self, ids: Ints) -> tuple[list[float | None], list[float | None]]:
        """Return slant range and standard deviation of the near edges of objects, m; None: not known now."""
        place = self._places(ids)
        known = self._known.rows
        near, sigma = known.near[place], np.sqrt(known.near_variance[place] + known.near_claim[place])
        told = (place >= 0) & (known.sights[place] > 0) & (known.seen_s[place] <= UNSEEN_S) if len(self._ids) else place >= 0
        return _where(told, near), _where(told, sigma)

    def outlines(self, snapshot: Snapshot) -> tuple[list[Outline | None], list[float]]:
        """Return the outlines of elongated objects, None for others, and how likely each is elongated."""
        none: list[Outline | None] = [None] * len(snapshot)
        return none, [0.0] * len(snapshot)
