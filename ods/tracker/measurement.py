"""Between the sonar's polar measurements and the global frame: eq. 1 with the pose at the ping, and its covariance.

The fan has no resolution in elevation: a measurement is a range and a bearing, and a vertical interval.
"""

from dataclasses import dataclass

import numpy as np

from ods.geometry import Array
from ods.tracker.scan import Echoes, Vehicle

NEAREST_M = 1e-3
"""Horizontal distances are kept above this, so that a direction exists."""


@dataclass(frozen=True, slots=True)
class Sight:
    """Where the sonar should see objects: arrays of one shape, such as (n,) or (hypotheses, n)."""

    range_m: Array
    """Slant range."""
    bearing: Array
    elevation: Array
    """In the body frame, up positive."""
    horizontal: Array
    """Horizontal distance, m."""
    along: Array
    """Variance of the predicted position along the line of sight, pose included, m^2;"""
    across: Array
    """across it;"""
    mixed: Array
    """and the covariance of both."""
    vertical: Array
    """Variance of the predicted height above the fan's plane, m^2."""

    def take(self, rows: int | slice) -> "Sight":
        """Return some rows of (hypotheses, n) arrays."""
        return Sight(*(getattr(self, name)[rows] for name in Sight.__slots__))


@dataclass(frozen=True, slots=True)
class Fix:
    """Measured positions in the global frame with their noise: (k,) arrays."""

    position: Array
    """(3, k) NED; down is the fan's middle there."""
    north: Array
    """Variance, m^2."""
    east: Array
    """Variance, m^2."""
    mixed: Array
    """Covariance of north and east, m^2."""
    half_height: Array
    """The object is within this of `position[2]`, m."""
    radius: Array
    radius_variance: Array


def sight(position: Array, variance: Array, covariance_ne: Array, vehicle: Vehicle) -> Sight:
    """Predict what the sonar measures of objects: eq. 1 solved for the body frame, and the covariance.

    `position`, `variance`: (3, ...) NED; `covariance_ne`: (...) of north and east.
    """
    flat = position.reshape(3, -1) - vehicle.position[:, None]
    offset = flat.reshape(position.shape)
    body = (vehicle.rotation.T @ flat).reshape(position.shape)
    horizontal = np.maximum(np.hypot(offset[0], offset[1]), NEAREST_M)
    north, east = offset[0] / horizontal, offset[1] / horizontal
    in_plane = np.hypot(body[0], body[1])
    slant = np.maximum(np.hypot(in_plane, body[2]), NEAREST_M)
    s_nn, s_ee, s_dd = vehicle.sigma_position**2
    p_nn, p_ee = variance[0] + s_nn, variance[1] + s_ee
    roll, pitch, yaw = vehicle.sigma_attitude**2
    nn, ee, ne = north * north, east * east, north * east
    turned = 2.0 * ne * covariance_ne
    square = horizontal * horizontal
    vertical = variance[2] + (square * max(roll, pitch) + s_dd)
    return Sight(
        range_m=slant,
        bearing=np.arctan2(body[1], body[0]),
        elevation=np.arctan2(-body[2], in_plane),
        horizontal=horizontal,
        along=nn * p_nn + turned + ee * p_ee + (body[2] / slant) ** 2 * vertical,
        across=ee * p_nn - turned + nn * p_ee + square * yaw,
        mixed=ne * (p_ee - p_nn) + (nn - ee) * covariance_ne,
        vertical=vertical,
    )


def fix(echoes: Echoes, vehicle: Vehicle, half_vertical: float, elevation: Array | None = None) -> Fix:
    """Return eq. 1, z_og = z_ag + R^-1 z_ob, for all echoes, with measurement noise that includes the pose's.

    `elevation`: (m,) where the echo is known to come from, for echoes of objects already tracked; by default the
    middle of the fan. `half_vertical`: half the fan's vertical opening, rad.
    """
    middle = echoes.elevation if elevation is None else elevation
    in_plane = echoes.range_m * np.cos(middle)
    cos_bearing, sin_bearing = np.cos(echoes.bearing), np.sin(echoes.bearing)
    below = -echoes.range_m * np.sin(middle)
    offset = vehicle.rotation @ np.array([in_plane * cos_bearing, in_plane * sin_bearing, below])
    # The height measured is that of the fan's middle, wherever in the fan the object is.
    offset[2] += vehicle.rotation[2, 2] * (-echoes.range_m * np.sin(echoes.elevation) - below)
    horizontal = np.maximum(np.hypot(offset[0], offset[1]), NEAREST_M)
    north, east = offset[0] / horizontal, offset[1] / horizontal
    along = echoes.sigma_range**2
    across = horizontal**2 * (echoes.sigma_bearing**2 + vehicle.sigma_attitude[2] ** 2)
    sigma = vehicle.sigma_position**2
    tilt = horizontal * max(vehicle.sigma_attitude[0], vehicle.sigma_attitude[1])
    return Fix(
        position=offset + vehicle.position[:, None],
        north=north**2 * along + east**2 * across + sigma[0],
        east=east**2 * along + north**2 * across + sigma[1],
        mixed=north * east * (along - across),
        half_height=echoes.range_m * np.sin(half_vertical) + vehicle.sigma_position[2] + tilt,
        radius=echoes.radius,
        radius_variance=echoes.sigma_radius**2,
    )
