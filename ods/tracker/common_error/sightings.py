"""Positions of tracked objects' echoes, and the shift of each by every common error."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.measurement.scan import Scan, Vehicle
from ods.tracker.output.snapshot import Snapshot

LARGEST_M = 4.0
"""Radius, m, of an object whose echo marks one position: of a wall each ping may show another part."""
REACH_M = 1.5
"""From an object's edge to the echo that is its own."""
LEAST_SIGMA_M, LEAST_SIGMA_RAD = 0.05, 0.003
"""Least standard deviation of an echo's position, m, whatever it claims."""

OWN = 4
"""Unknowns of each object, the first columns of the design: north, east, m; by how much the echo is nearer than the
middle, m; the square of the difference in depth, m^2, which makes a slant range longer by 1 / (2 range) of it."""
YAW, TURN, SCALE, LATENCY, NORTH, EAST = range(OWN, OWN + 6)
"""The columns of the errors in common: of the heading, rad, and its rate, rad/s; of the ranges, a share; of the poses'
time, s (positive: they are stamped too early); rates of the place, m/s. Rates count from now: both are 0 now."""
COLUMNS = OWN + 6


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
    objects = snapshot.take((snapshot.state == ACTIVE) & (snapshot.radius < LARGEST_M))
    vehicle, echoes = scan.vehicle, scan.echoes
    if vehicle is None or not len(objects) or not len(echoes):
        return _none()
    offset = _offsets(vehicle, echoes.rows.range_m, echoes.rows.bearing)
    place = vehicle.position[:2] + offset
    off = np.linalg.norm(objects.position[:2].T[:, None] - place[None], axis=2)
    nearest = off.argmin(axis=1)
    own = off[np.arange(len(objects)), nearest] < REACH_M + objects.radius
    echo = nearest[own]
    sigma_range = np.maximum(echoes.rows.sigma_range[echo], LEAST_SIGMA_M)
    sigma_bearing = np.maximum(echoes.rows.sigma_bearing[echo], LEAST_SIGMA_RAD)
    return Sightings(
        objects.id[own],
        place[echo],
        design_of(offset[echo], motion),
        _whitening(offset[echo], sigma_range, sigma_bearing),
    )


def design_of(offset: Floats, motion: Motion) -> Floats:
    """Return (k, 2, COLUMNS) by how much each unknown moves places that are `offset`, (k, 2), from the head."""
    away = np.linalg.norm(offset, axis=1)[:, None]
    ahead = offset / away
    turned = np.column_stack([-offset[:, 1], offset[:, 0]])
    design = np.zeros((len(offset), 2, COLUMNS))
    design[:, 0, 0] = design[:, 1, 1] = 1.0
    design[:, :, 2], design[:, :, 3] = -ahead, ahead / (2.0 * away)
    design[:, :, YAW], design[:, :, SCALE] = turned, offset
    design[:, :, LATENCY] = motion.velocity + motion.yaw_rate * turned
    return design


def _offsets(vehicle: Vehicle, range_m: Floats, bearing: Floats) -> Floats:
    """Return (m, 2) north, east from the head to echoes, as if they were level with it."""
    ahead = np.column_stack([np.cos(bearing), np.sin(bearing)]) @ vehicle.rotation[:2, :2].T
    length: Floats = np.linalg.norm(ahead, axis=1)
    return np.asarray(ahead * (range_m / np.maximum(length, 1e-6))[:, None])


def _whitening(offset: Floats, sigma_range: Floats, sigma_bearing: Floats) -> Floats:
    away = np.linalg.norm(offset, axis=1)
    ahead = offset / away[:, None]
    across = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    return np.stack([ahead / sigma_range[:, None], across / (away * sigma_bearing)[:, None]], axis=1)


def _none() -> Sightings:
    return Sightings(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros((0, 2, COLUMNS)), np.zeros((0, 2, 2)))
