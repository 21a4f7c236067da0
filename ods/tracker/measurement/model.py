"""Between the sonar's polar measurements and the global frame: eq. 1 with the pose at the ping, and its covariance.

The fan has no resolution in elevation: a measurement is a range and a bearing, and a vertical interval.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.kernel import kernel
from ods.tracker.measurement.scan import (
    BEARING,
    ELEVATION,
    RANGE,
    SIGMA_BEARING,
    SIGMA_RADIUS,
    SIGMA_RANGE,
    Echoes,
    Vehicle,
)

NEAREST_M = 1e-3
"""Horizontal distances are kept above this, so that a direction exists."""


class Sight(NamedTuple):
    """Where the sonar should see objects: arrays of one shape, such as (n,) or (hypotheses, n)."""

    range_m: Floats
    """Slant range."""
    bearing: Floats
    elevation: Floats
    """In the body frame, up positive."""
    horizontal: Floats
    """Horizontal distance, m."""
    along: Floats
    """Variance of the predicted position along the line of sight, pose included, m^2;"""
    across: Floats
    """across it;"""
    mixed: Floats
    """and the covariance of both."""
    vertical: Floats
    """Variance of the predicted height above the fan's plane, m^2."""


class Fix(NamedTuple):
    """Measured positions in the global frame with their noise: (k,) arrays."""

    position: Floats
    """(3, k) NED; down is the fan's middle there."""
    north: Floats
    """Variance, m^2."""
    east: Floats
    """Variance, m^2."""
    mixed: Floats
    """Covariance of north and east, m^2."""
    half_height: Floats
    """The object is within this of `position[2]`, m."""
    radius: Floats
    radius_variance: Floats


@kernel
def wrapped(angle: float) -> float:
    """Return the angle wrapped to [-pi, pi)."""
    if -math.pi <= angle < math.pi:
        return angle
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def sight(position: Floats, variance: Floats, covariance_ne: Floats, vehicle: Vehicle) -> Sight:
    """Predict what the sonar measures of objects: eq. 1 solved for the body frame, and the covariance.

    `position`, `variance`: (3, n) or (h, 3, n) NED; `covariance_ne`: (n,) or (h, n) of north and east.
    """
    if position.ndim == 2:
        return Sight(*_sight(position[None], variance[None], covariance_ne[None], vehicle)[:, 0])
    return Sight(*_sight(position, variance, covariance_ne, vehicle))


@kernel
def _sight(position: Floats, variance: Floats, covariance_ne: Floats, vehicle: Vehicle) -> Floats:
    """Return the (8, h, n) fields of `Sight` for h hypotheses: (h, 3, n), (h, 3, n), (h, n)."""
    hypotheses, _, n = position.shape
    rotation = vehicle.rotation
    s_nn, s_ee, s_dd = vehicle.sigma_position[0] ** 2, vehicle.sigma_position[1] ** 2, vehicle.sigma_position[2] ** 2
    tilt = max(vehicle.sigma_attitude[0] ** 2, vehicle.sigma_attitude[1] ** 2)
    yaw = vehicle.sigma_attitude[2] ** 2
    seen = np.empty((8, hypotheses, n))
    for h in range(hypotheses):
        for i in range(n):
            x = position[h, 0, i] - vehicle.position[0]
            y = position[h, 1, i] - vehicle.position[1]
            z = position[h, 2, i] - vehicle.position[2]
            ahead = rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z
            right = rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z
            below = rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z
            horizontal = max(math.hypot(x, y), NEAREST_M)
            in_plane = math.hypot(ahead, right)
            slant = max(math.hypot(in_plane, below), NEAREST_M)
            north, east = x / horizontal, y / horizontal
            p_nn, p_ee, p_ne = variance[h, 0, i] + s_nn, variance[h, 1, i] + s_ee, covariance_ne[h, i]
            mixed = 2.0 * north * east * p_ne
            square = horizontal**2
            vertical = variance[h, 2, i] + square * tilt + s_dd
            seen[0, h, i] = slant
            seen[1, h, i] = math.atan2(right, ahead)
            seen[2, h, i] = math.atan2(-below, in_plane)
            seen[3, h, i] = horizontal
            seen[4, h, i] = north**2 * p_nn + mixed + east**2 * p_ee + (below / slant) ** 2 * vertical
            seen[5, h, i] = east**2 * p_nn - mixed + north**2 * p_ee + square * yaw
            seen[6, h, i] = north * east * (p_ee - p_nn) + (north**2 - east**2) * p_ne
            seen[7, h, i] = vertical
    return seen


def fix(echoes: Echoes, vehicle: Vehicle, half_vertical: float, elevation: Floats | None = None) -> Fix:
    """Return eq. 1, z_og = z_ag + R^-1 z_ob, for all echoes, with measurement noise that includes the pose's.

    `elevation`: (m,) where the echo is known to come from, for echoes of objects already tracked; by default the
    middle of the fan. `half_vertical`: half the fan's vertical opening, rad.
    """
    middle = echoes.elevation if elevation is None else elevation
    found = _fix(echoes.table, middle, vehicle, half_vertical)
    return Fix(found[0:3], found[3], found[4], found[5], found[6], echoes.radius, found[7])


@kernel
def _fix(echoes: Floats, elevation: Floats, vehicle: Vehicle, half_vertical: float) -> Floats:
    """Return (8, m): the fields of `Fix` one after another, but for the radius."""
    count = echoes.shape[1]
    rotation = vehicle.rotation
    s_nn, s_ee = vehicle.sigma_position[0] ** 2, vehicle.sigma_position[1] ** 2
    tilt = max(vehicle.sigma_attitude[0], vehicle.sigma_attitude[1])
    found = np.empty((8, count))
    for j in range(count):
        distance, bearing = echoes[RANGE, j], echoes[BEARING, j]
        in_plane, below = distance * math.cos(elevation[j]), -distance * math.sin(elevation[j])
        ahead, right = in_plane * math.cos(bearing), in_plane * math.sin(bearing)
        x = rotation[0, 0] * ahead + rotation[0, 1] * right + rotation[0, 2] * below
        y = rotation[1, 0] * ahead + rotation[1, 1] * right + rotation[1, 2] * below
        # The height measured is that of the fan's middle, wherever in the fan the object is.
        z = rotation[2, 0] * ahead + rotation[2, 1] * right - rotation[2, 2] * distance * math.sin(echoes[ELEVATION, j])
        horizontal = max(math.hypot(x, y), NEAREST_M)
        north, east = x / horizontal, y / horizontal
        along = echoes[SIGMA_RANGE, j] ** 2
        across = horizontal**2 * (echoes[SIGMA_BEARING, j] ** 2 + vehicle.sigma_attitude[2] ** 2)
        found[0, j] = x + vehicle.position[0]
        found[1, j] = y + vehicle.position[1]
        found[2, j] = z + vehicle.position[2]
        found[3, j] = north**2 * along + east**2 * across + s_nn
        found[4, j] = east**2 * along + north**2 * across + s_ee
        found[5, j] = north * east * (along - across)
        found[6, j] = distance * math.sin(half_vertical) + vehicle.sigma_position[2] + horizontal * tilt
        found[7, j] = echoes[SIGMA_RADIUS, j] ** 2
    return found
