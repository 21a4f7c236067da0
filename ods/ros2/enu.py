"""From ODS's frames to those of ROS and Foxglove (REP 103): NED to ENU, FRD to FLU. Only this package turns them.

World: east, north, up from the same origin. Body, and the sonar's head: forward, port, up. A ROS heading is counted
from east, to port: yaw is 90 deg less the heading. The fan's frame is that of marine_acoustic_msgs: x up, y starboard,
z ahead.
"""

import math

from ods.base.frames.quaternion import Quaternion, Vector3, product

_HALF = math.sqrt(0.5)
NED_TO_ENU: Quaternion = (0.0, _HALF, _HALF, 0.0)
"""Half a turn about the axis between north and east: swaps these two and turns down to up."""
FLU_TO_FRD: Quaternion = (0.0, 1.0, 0.0, 0.0)
FAN_TO_HEAD: Quaternion = (0.0, _HALF, 0.0, _HALF)
"""From the fan's axes to the head's (FLU): x to up, y to starboard, z to ahead."""


def enu(ned: Vector3) -> Vector3:
    """Return a position or velocity of the world."""
    return ned[1], ned[0], -ned[2]


def flu(frd: Vector3) -> Vector3:
    """Return a position or velocity on the vehicle or its sonar."""
    return frd[0], -frd[1], -frd[2]


def attitude(body_to_ned: Quaternion) -> Quaternion:
    """Return the attitude (w, x, y, z) that turns FLU vectors into ENU ones, of one that turns FRD ones into NED."""
    return product(product(NED_TO_ENU, body_to_ned), FLU_TO_FRD)


def mounting(head_to_body: Quaternion) -> Quaternion:
    """Return the turn between two FLU frames, of that between the same as FRD."""
    w, x, y, z = head_to_body
    return w, x, -y, -z


def fan(bearing_rad: float, elevation_rad: float) -> Vector3:
    """Return the unit vector of a beam in the fan's frame; bearing positive to starboard, elevation up."""
    level = math.cos(elevation_rad)
    return math.sin(elevation_rad), level * math.sin(bearing_rad), level * math.cos(bearing_rad)


def covariance(sigma_ned: Vector3, covariance_ne: float = 0.0) -> tuple[float, ...]:
    """Return the 3 x 3 covariance in ENU, row by row, of standard deviations in NED."""
    north, east, down = sigma_ned
    return (east * east, covariance_ne, 0.0, covariance_ne, north * north, 0.0, 0.0, 0.0, down * down)
