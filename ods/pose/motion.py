"""Does the vehicle's place move as its velocity reports? A wrong unit or axis shows after some metres."""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.quaternion import rotated
from ods.messages import Pose

LONGEST_STEP_S = 1.0
"""Between two poses whose places are compared; a velocity reports little about more."""
SLACK_M, SLACK = 1.0, 0.3
"""Allowed difference of distances, m, and as a share of the longer one, besides the position's standard deviation."""
UNITS = {3.6: "km/h", 1.944: "knots", 3.281: "ft/s", 100.0: "cm/s", 1000.0: "mm/s"}
"""How many of each are one m/s."""
NEAR_UNIT = 0.1
"""Share by which the ratio of two distances may differ from one of UNITS."""


class PoseMotion:
    """A stretch of the vehicle's way, by its places and by its velocities."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._moved, self._by_velocity = np.zeros(3), np.zeros(3)
        self._sigma_m = 0.0

    def add(self, earlier: Pose, later: Pose) -> None:
        """Take in the way between two poses, one after the other; none over a gap."""
        step_s = (later.t_ns - earlier.t_ns) / NS
        if 0.0 < step_s <= LONGEST_STEP_S:
            self._moved += np.subtract(later.position_ned, earlier.position_ned)
            self._by_velocity += 0.5 * step_s * np.add(_velocity(earlier), _velocity(later))
            self.seconds += step_s
            self._sigma_m = max(later.sigma_position_ned)

    def disagreement(self) -> str:
        """Return how places and velocities differ, and what to look at; "" where they do not."""
        moved_m, by_velocity_m = float(np.linalg.norm(self._moved)), float(np.linalg.norm(self._by_velocity))
        if np.linalg.norm(self._moved - self._by_velocity) <= SLACK_M + self._sigma_m + SLACK * max(
            moved_m, by_velocity_m
        ):
            return ""
        return (
            f"the position moved by {_vector(self._moved)} m within {self.seconds:.1f} s, "
            "but by the reported velocity it would be "
            f"{_vector(self._by_velocity)} m (north, east, down): {_guess(moved_m, by_velocity_m)}"
        )


def _velocity(pose: Pose) -> tuple[float, float, float]:
    """Return the velocity in the local frame, m/s."""
    norm = math.hypot(*pose.attitude) or 1.0
    w, x, y, z = (part / norm for part in pose.attitude)
    return rotated((w, x, y, z), pose.velocity_body)


def _vector(vector: Floats) -> str:
    return ", ".join(f"{part:.1f}" for part in vector)


def _guess(moved_m: float, by_velocity_m: float) -> str:
    """Return what to look at."""
    for factor, unit in UNITS.items():
        if abs(by_velocity_m - factor * moved_m) < NEAR_UNIT * factor * moved_m:
            return f"is the velocity in {unit}?"
    return "are the units and axes of velocity, attitude and position right?"
