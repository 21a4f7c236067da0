"""Pose of the vehicle, and its set points."""

from typing import Annotated

import msgspec

from ods.messages.fields import (
    Coordinate,
    Coordinates,
    Count,
    Height,
    Instant,
    Part,
    Quaternion,
    Uncertainty,
    UtcSource,
    Vector3,
    Velocity,
)


class Pose(msgspec.Struct, frozen=True):
    """Pose of the vehicle's origin from its navigation filter."""

    seq: Count
    t_ns: Instant
    utc_ns: Instant
    position_ned: Coordinates
    attitude: tuple[Part, Part, Part, Part]
    velocity_body: Velocity
    """FRD, m/s."""
    sigma_position_ned: Coordinates
    """m."""
    sigma_attitude: tuple[Uncertainty, Uncertainty, Uncertainty]
    """Roll, pitch, yaw, rad."""
    utc_source: UtcSource = "unsure"
    altitude_m: Height | None = None
    """Of the vehicle's origin over the bottom below; none: not reported, or implausible."""
    sigma_altitude_m: Coordinate = 0.0


class Site(msgspec.Struct, frozen=True):
    """Origin of the local frame, on the ellipsoid of WGS 84 (height 0)."""

    latitude_deg: Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)]
    longitude_deg: Annotated[float, msgspec.Meta(ge=-180.0, le=180.0)]


class PoseAt(msgspec.Struct, frozen=True):
    """Pose of the vehicle's origin, or of the sonar's head, at one instant, interpolated."""

    position_ned: Vector3
    attitude: Quaternion
    """Body, or head, to global."""
    velocity_ned: Vector3
    """Of the vehicle's origin, m/s."""
    sigma_position: Vector3
    sigma_attitude: Vector3
    """The vehicle's roll, pitch, yaw, rad."""
    extrapolated_s: float = 0.0
    """Time since the `Pose` from which it was extrapolated; 0: interpolated."""


class VehicleSetPoint(msgspec.Struct, frozen=True):
    """Set point of the reference planner for the simulated vehicle."""

    seq: Count
    t_ns: Instant
    """When it was made; it holds until the next one."""
    utc_ns: Instant
    heading_rad: float
    """From north to east."""
    speed_m_s: float
    """Through the water."""
    down_m: float
    """Of the vehicle's origin."""
    list_seq: Count
    """`seq` of its `ObstacleList`."""
    avoiding: bool
    """Something blocks the path to the way-point."""
    valid: bool
    """False: that list is not valid or too old."""
    arrived: bool
    """The last way-point is reached."""
