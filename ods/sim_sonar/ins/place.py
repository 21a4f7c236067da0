"""Where on the vehicle the simulated INS is, and what it knows there."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames.geometry import rotation_matrix
from ods.base.frames.quaternion import Quaternion, Vector3, conjugate, product
from ods.base.geodesy import LocalFrame
from ods.sim_sonar.scene.timeline import Scene

STEP_S = 1e-3
"""For the rate of turn."""


class InsPlace(NamedTuple):
    """Of one INS."""

    frame: LocalFrame
    """Of the scene."""
    lever_m: Vector3 = (0.0, 0.0, 0.0)
    """Its reference point, forward, starboard, down of the vehicle's origin, m."""

    def told(self, scene: Scene, t_s: float) -> tuple[Floats, Quaternion, Floats]:
        """Return what it tells: its place (3,) NED in the scene, attitude there, and velocity (3,) along body axes.

        The attitude is from true north, and from the level, where it is.
        """
        vehicle = scene.vehicle_at(t_s)
        north, east, down = vehicle.position_ned.tolist()
        w, x, y, z = vehicle.attitude.tolist()
        attitude = product(conjugate(self.frame.turn_at((north, east, down))), (w, x, y, z))
        if self.lever_m == (0.0, 0.0, 0.0):
            return vehicle.position_ned, attitude, vehicle.velocity_body
        turn = rotation_matrix(scene.pose_at(np.array([t_s - STEP_S, t_s, t_s + STEP_S])).attitude)
        swing = turn[1].T @ (turn[2] - turn[0]) @ self.lever_m / (2.0 * STEP_S)
        return vehicle.position_ned + turn[1] @ self.lever_m, attitude, vehicle.velocity_body + swing


def over_bottom(scene: Scene, place: Floats) -> float | None:
    """Return the height of a place, (3,) NED, over the bottom right below, m; None in a scene without a sea-bed."""
    return None if scene.sea_bed is None else scene.sea_bed.altitude_of(place)
