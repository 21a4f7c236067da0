"""Positions of tracked objects' echoes, and the shift of each by every common error."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.compiled import native
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.measurement.scan import Scan
from ods.tracker.output.snapshot import Snapshot

LARGEST_M = 4.0
"""Radius, m, of an object whose echo marks one position: of a wall each ping may show another part."""
REACH_M = 1.5
"""From an object's edge to the echo that is its own."""
LEAST_SIGMA_M, LEAST_SIGMA_RAD = 0.05, 0.003
"""Least standard deviation of an echo's position, m, whatever it claims."""

WHOLE = 11
NORTH_OF_OBJECT, EAST_OF_OBJECT, NEARER, DEPTH, YAW, TURN, SCALE, LATENCY, NORTH, EAST, COLUMNS = range(WHOLE)
"""Columns of the design. First the unknowns of each object: north, east, m; by how much the echo is nearer than the
middle, m; the square of the difference in depth, m^2, which makes a slant range longer by 1 / (2 range) of it. Then
the errors in common: of the heading, rad, and its rate, rad/s; of the ranges, a share; of the poses' time, s (positive:
they are stamped too early); rates of the place, m/s. Rates count from now: both are 0 now. Normal equations have one
more, that of the places seen."""
OWN = YAW
"""Number of unknowns of each object."""


class Motion(NamedTuple):
    """The vehicle's at a ping."""

    velocity: Floats
    """(2,) north, east, m/s."""
    yaw_rate: float
    """rad/s."""


class Sightings(NamedTuple):
    """k objects, static or not, each seen once in a ping."""

    id: Ints
    """(k,)"""
    place: Floats
    """(k, 2) north, east of the echo, m, by the pose as it was reported."""
    design: Floats
    """(k, 2, COLUMNS): by how much each unknown moves the place."""
    whitening: Floats
    """(k, 2, 2): times an error of the place, independent errors of variance 1."""


def sightings_of(snapshot: Snapshot, scan: Scan, motion: Motion) -> Sightings:
    """Return the active objects that are not large, each with its nearest echo; none without a pose."""
    vehicle, echoes, n = scan.vehicle, scan.echoes.rows, len(snapshot)
    which, place, design, whitening = np.empty(n, np.int64), np.empty((n, 2)), _designs(n), np.empty((n, 2, 2))
    if vehicle is None:
        return Sightings(which[:0], place[:0], design[:0], whitening[:0])
    judged = (snapshot.state == ACTIVE) & (snapshot.radius < LARGEST_M)
    objects = judged, np.ascontiguousarray(snapshot.position), np.ascontiguousarray(snapshot.radius)
    received = echoes.range_m, echoes.bearing, echoes.sigma_range, echoes.sigma_bearing
    limits, answer = (REACH_M, LEAST_SIGMA_M, LEAST_SIGMA_RAD), (which, place, design, whitening)
    count = native.common_sightings(objects, received, vehicle.position, vehicle.rotation, *motion, limits, answer)
    return Sightings(snapshot.id[which[:count]], place[:count], design[:count], whitening[:count])


def design_of(offset: Floats, motion: Motion) -> Floats:
    """Return (k, 2, COLUMNS) by how much each unknown moves places that are `offset`, (k, 2), from the head."""
    design = _designs(len(offset))
    native.common_designs(np.ascontiguousarray(offset), *motion, design)
    return design


def _designs(count: int) -> Floats:
    return np.empty((count, 2, COLUMNS))
