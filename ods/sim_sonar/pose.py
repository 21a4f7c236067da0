"""Where the vehicle is and how it is turned."""

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
