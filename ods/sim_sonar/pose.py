"""Poses of vehicle and sonar, and the pings that are sent from there."""

from typing import NamedTuple

from ods.base.arrays import Floats

Times = float | Floats
"""Scene time, s: one, or an array of any shape (...)."""


class VehiclePose(NamedTuple):
    """The vehicle, or its sonar's head, at one time or at times (...)."""

    position_ned: Floats
    """(..., 3) m."""
    attitude: Floats
    """(..., 4) unit quaternion, body to global."""


class Transmission(NamedTuple):
    """One ping as it is sent."""

    pose: VehiclePose
    t_s: float = 0.0
    """Scene time, s."""
    ping_number: int = 0
