"""Closest point of approach: how near each object comes to the vehicle if both go on as they do now.

In the horizontal plane, to the object's edge: objects stand for vertical cylinders, their depth is hardly observed.
"""

from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import MotionSettings


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
    """Standard deviation of the distance: the object's place then, and its radius; the vehicle's course is taken
    as it is."""


def closest_approach(snapshot: Snapshot, course: Course, motion: MotionSettings, horizon_s: float) -> Approach:
    """Return the closest approach within the next `horizon_s` seconds of every object."""
    offset = snapshot.position[:2] - course.position[:2, None]
    drift = snapshot.velocity[:2] - course.velocity[:2, None]
    closing, speed_2 = -(offset * drift).sum(axis=0), (drift * drift).sum(axis=0)
    time = np.where(closing > 0.0, horizon_s, 0.0)
    np.divide(closing, speed_2, out=time, where=(closing > 0.0) & (closing < speed_2 * horizon_s))
    north, east = offset + drift * time
    distance = np.hypot(north, east)
    then = snapshot.carried_on(time, motion)
    sigma_north, sigma_east = then.sigma_position[:2]
    squared = (north * sigma_north) ** 2 + (east * sigma_east) ** 2 + 2.0 * north * east * then.covariance_ne
    along = np.maximum(sigma_north, sigma_east) ** 2  # at distance 0 any direction
    np.divide(squared, distance**2, out=along, where=distance > 1e-6)
    return Approach(time, distance - snapshot.radius, np.sqrt(np.maximum(along, 0.0) + snapshot.sigma_radius**2))
