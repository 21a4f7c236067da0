"""Which echoes of a ping are of which confirmed object: by its circle, or by its outline where that is known."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.compiled import native
from ods.tracker.outline.seen import GlobalEchoes
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import MARGIN_SIGMAS

GATE = 1.5
"""An echo is of the object whose ellipse it fits best, if it is no farther from the object's place than so many times
the ellipse's axes, to which are added in squares"""
GATE_M = 0.5
"""`MARGIN_SIGMAS` standard deviations, and this."""


class Extents(NamedTuple):
    """Of n objects: (n,) each."""

    extended: Mask
    """Those with an outline; the others are round, as far as is known yet."""
    north: Floats
    """From the object's place to the outline's middle, m."""
    east: Floats
    north_north: Floats
    """Second moments about it, m^2."""
    north_east: Floats
    east_east: Floats


def owners_of(snapshot: Snapshot, seen: GlobalEchoes, known: Extents, utc_ns: int) -> Ints:
    """Return (m,) the objects seen at `utc_ns` that the echoes are of, each of one at most; -1: of none."""
    owner = np.empty(len(seen.near), np.int64)
    circles = snapshot.position, snapshot.sigma_position, snapshot.radius, snapshot.sigma_radius
    extended, *extents = known
    live = snapshot.last_seen_utc_ns == utc_ns
    of_objects = live, extended, *map(np.ascontiguousarray, circles), *extents
    native.owners_of(of_objects, seen, GATE, MARGIN_SIGMAS, GATE_M, owner)
    return owner
