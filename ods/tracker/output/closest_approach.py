"""Closest point of approach: how near each object comes to the vehicle if both keep their velocities.

In the horizontal plane, to the object's edge: objects stand for vertical cylinders, their depth is hardly observed.
"""

from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
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
    """Standard deviation of the distance: the object's place then, and its radius; or, where that is more, what its
    velocity may make of the time, too: what seems to fall behind, or to stay as far away, may as well come nearer for
    the whole horizon. That is by sigma points, sqrt(2) standard deviations of the velocity away from the mean to either
    side (S. J. Julier, J. K. Uhlmann, Proc. IEEE 92(3), 2004, no weight on the mean). The vehicle's course is taken as
    it is."""


def closest_approach(snapshot: Snapshot, course: Course, motion: MotionSettings, horizon_s: float) -> Approach:
    """Return the closest approach within the next `horizon_s` seconds of every object."""
    time_s, distance_m, sigma_m = np.empty((3, len(snapshot)))
    spread = np.ascontiguousarray(snapshot.covariance_ne), np.ascontiguousarray(snapshot.sigma_radius)
    native.closest_approaches(
        snapshot.movers(motion), spread, course.position, course.velocity, horizon_s, time_s, distance_m, sigma_m
    )
    return Approach(time_s, distance_m - snapshot.radius, sigma_m)
