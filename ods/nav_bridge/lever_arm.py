"""Transforms poses of the INS's reference point to the body's origin, which all other code uses."""

import msgspec

from ods.base.clock import NS
from ods.base.frames.mounting import spread_at
from ods.base.frames.quaternion import Quaternion, Vector3, conjugate, product, rotated
from ods.messages import Pose

LONGEST_NS = NS // 2
"""Between two poses of which the rate of turn is taken."""


class LeverArm:
    """Moves each pose by the way from the INS to the origin.

    In a turn the velocity differs between both places, by 1 m/s for 3 m at 20 deg/s. The rate of turn is that since
    the pose before; with none within half a second it counts as 0.
    """

    def __init__(self, lever_m: Vector3) -> None:
        """`lever_m`: the INS's reference point, forward, starboard, down of the origin, m."""
        self._lever = lever_m
        self._before: Pose | None = None

    def at_origin(self, pose: Pose) -> Pose:
        """Return the pose of the body's origin. Poses are given in order of time; others' rate of turn counts as 0."""
        if self._lever == (0.0, 0.0, 0.0):
            return pose
        way = rotated(pose.attitude, self._lever)
        turn = _rate_of_turn(self._before, pose)
        self._before = pose
        altitude = None if pose.altitude_m is None else max(pose.altitude_m + way[2], 0.0)
        return msgspec.structs.replace(
            pose,
            position_ned=_minus(pose.position_ned, way),
            velocity_body=_minus(pose.velocity_body, _cross(turn, self._lever)),
            sigma_position_ned=spread_at(way, pose.sigma_position_ned, pose.sigma_attitude),
            altitude_m=altitude,
        )


def _rate_of_turn(before: Pose | None, now: Pose) -> Vector3:
    """Return the body's rate of turn about its axes, rad/s."""
    if before is None or not 0 < now.t_ns - before.t_ns <= LONGEST_NS:
        return 0.0, 0.0, 0.0
    turned: Quaternion = product(conjugate(before.attitude), now.attitude)
    per_s = 2.0 * NS / (now.t_ns - before.t_ns) * (1.0 if turned[0] >= 0.0 else -1.0)
    return per_s * turned[1], per_s * turned[2], per_s * turned[3]


def _cross(a: Vector3, b: Vector3) -> Vector3:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _minus(a: Vector3, b: Vector3) -> Vector3:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]
