"""Where the vehicle is, how it is turned, and the pings that it sends from there."""

from typing import NamedTuple

from ods.base.arrays import Floats

Times = float | Floats
"""Scene time, s: one, or an array of any shape (...)."""


class VehiclePose(NamedTuple):
    """The vehicle at one time, or at times (...); the sonar sits at its origin and looks along its bow."""

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
