"""Closest point of approach: how near each object comes to the vehicle if both keep their velocities.

In the horizontal plane, to the object's edge: objects stand for vertical cylinders, their depth is hardly observed.
"""

import math
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import MotionSettings

SIGMA_POINTS = math.sqrt(2.0) * np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])[:, :, None]
"""(2, 4, 1) standard deviations, north and east."""


@dataclass(frozen=True, slots=True)
class Course:
    """The vehicle's present course and speed."""

    position: Floats
    """(3,) NED, m."""
    velocity: Floats
    """(3,) NED, m/s."""


@dataclass(frozen=True, slots=True)
class Approach:
    """(n,) each."""

    time_s: Floats
    """From now, in [0, horizon]; 0 when the distance does not shrink, or never changes."""
    distance_m: Floats
    """From the vehicle's origin to the object's edge at that time; below 0 inside it."""
    sigma_m: Floats
    """Standard deviation of the distance: the object's place then, and its radius; or, where that is more, what its
    velocity may make of the time, too. The vehicle's course is taken as it is."""


def closest_approach(snapshot: Snapshot, course: Course, motion: MotionSettings, horizon_s: float) -> Approach:
    """Return the closest approach within the next `horizon_s` seconds of every object."""
    offset = snapshot.position[:2] - course.position[:2, None]
    drift = snapshot.velocity[:2] - course.velocity[:2, None]
    time = _nearest_after(offset, drift, horizon_s)
    nearest = offset + drift * time
    distance = np.hypot(*nearest)
    at_that_time = _along(nearest, snapshot.extrapolated(time, motion))
    by_velocity = _by_velocity(offset, drift, snapshot.sigma_velocity[:2], horizon_s, distance)
    at_others = _along(nearest, snapshot) + by_velocity
    variance = np.maximum(at_that_time, at_others) + snapshot.sigma_radius**2
    return Approach(time, distance - snapshot.radius, np.sqrt(variance))


def _nearest_after(offset: Floats, drift: Floats, horizon_s: float) -> Floats:
    """Return (..., n) the times of the closest approach of places and relative velocities, (2, ..., n)."""
    closing, speed_2 = -(offset * drift).sum(axis=0), (drift * drift).sum(axis=0)
    time = np.where(closing > 0.0, horizon_s, 0.0)
    np.divide(closing, speed_2, out=time, where=(closing > 0.0) & (closing < speed_2 * horizon_s))
    return time


def _along(nearest: Floats, picture: Snapshot) -> Floats:
    """Return (n,) variances of the places of `picture` along `nearest`, (2, n)."""
    (north, east), (sigma_north, sigma_east) = nearest, picture.sigma_position[:2]
    squared = (north * sigma_north) ** 2 + (east * sigma_east) ** 2 + 2.0 * north * east * picture.covariance_ne
    along = np.maximum(sigma_north, sigma_east) ** 2  # at distance 0 any direction
    distance = np.hypot(north, east)
    np.divide(squared, distance**2, out=along, where=distance > 1e-6)
    return np.asarray(np.maximum(along, 0.0))


def _by_velocity(offset: Floats, drift: Floats, sigma: Floats, horizon_s: float, distance_m: Floats) -> Floats:
    """Return (n,) mean squares by which `distance_m` changes with the velocity, of standard deviations (2, n).

    What seems to fall behind, or to stay as far away as it is, may as well come nearer for the whole horizon: then the
    time changes, and the spread at one time shows nothing of it. By sigma points, sqrt(2) standard deviations away from
    the mean to either side (S. J. Julier, J. K. Uhlmann, Proc. IEEE 92(3), 2004, with no weight on the mean).
    """
    moved = drift[:, None] + SIGMA_POINTS * sigma[:, None]
    nearest = offset[:, None] + moved * _nearest_after(offset[:, None], moved, horizon_s)
    return np.asarray(((np.hypot(*nearest) - distance_m) ** 2).mean(axis=0))
