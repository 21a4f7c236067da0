"""The pose of the sonar's head: whatever speaks of an image speaks of it, not of the vehicle."""

import dataclasses

import numpy as np

from ods.base.frames.mounting import Mounting, spread_at
from ods.pose.buffer import PoseEstimate


def head_of(vehicle: PoseEstimate | None, mounting: Mounting) -> PoseEstimate | None:
    """Return the head's pose: place, attitude and the place's standard deviation; None as the vehicle's.

    The velocity stays that of the body's origin, the standard deviation of attitude that of the vehicle.
    """
    if vehicle is None or mounting.is_none:
        return vehicle
    north, east, down = vehicle.position_ned.tolist()
    w, x, y, z = vehicle.attitude.tolist()
    place, attitude, lever = mounting.head((north, east, down), (w, x, y, z))
    spread = spread_at(lever, tuple(vehicle.sigma_position.tolist()), tuple(vehicle.sigma_attitude.tolist()))
    return dataclasses.replace(
        vehicle,
        position_ned=np.array(place),
        attitude=np.array(attitude),
        sigma_position=np.array(spread),
        altitude_m=None if vehicle.altitude_m is None else vehicle.altitude_m - lever[2],
    )
