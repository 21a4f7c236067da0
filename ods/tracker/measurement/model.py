"""Between the sonar's polar measurements and the global frame: eq. 1 with the pose at the ping, and its covariance.

The fan has no resolution in elevation: a measurement is a range and a bearing, and a vertical interval.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel
from ods.tracker.measurement.scan import Echoes, Vehicle, echo_rows
from ods.tracker.named import Named

NEAREST_M = 1e-3
"""Horizontal distances are kept above this, so that a direction exists."""


class PredictedMeasurement(NamedTuple):
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


PREDICTED = len(PredictedMeasurement._fields)


@kernel
def predicted_rows(table: Floats) -> PredictedMeasurement:
    """Name the rows of an (8, ...) table."""
    return PredictedMeasurement(table[0], table[1], table[2], table[3], table[4], table[5], table[6], table[7])


class PositionMeasurement(NamedTuple):
    """Echoes converted to positions in the global frame, with their noise: (k,) arrays."""

    position: Floats
    """(3, k) NED; down is the fan's middle there."""
    variance_north: Floats
    """m^2."""
    variance_east: Floats
    """m^2."""
    covariance_ne: Floats
    """Of north and east, m^2."""
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


def predicted_measurement(
    position: Floats, variance: Floats, covariance_ne: Floats, vehicle: Vehicle
) -> Named[PredictedMeasurement]:
    """Predict what the sonar measures of objects: eq. 1 solved for the body frame, and the covariance.

    `position`, `variance`: (3, n) or (h, 3, n) NED; `covariance_ne`: (n,) or (h, n) of north and east.
    """
    if position.ndim == 2:
        one = _predicted_measurement(position[None], variance[None], covariance_ne[None], vehicle)
        return Named(PredictedMeasurement, one[:, 0])
    return Named(PredictedMeasurement, _predicted_measurement(position, variance, covariance_ne, vehicle))


@kernel
def _predicted_measurement(position: Floats, variance: Floats, covariance_ne: Floats, vehicle: Vehicle) -> Floats:
    """Return (8, h, n) predictions for h hypotheses: (h, 3, n), (h, 3, n), (h, n)."""
    rotation = vehicle.rotation
    s_nn, s_ee, s_dd = vehicle.sigma_position[0] ** 2, vehicle.sigma_position[1] ** 2, vehicle.sigma_position[2] ** 2
    tilt = max(vehicle.sigma_attitude[0] ** 2, vehicle.sigma_attitude[1] ** 2)
    yaw = vehicle.sigma_attitude[2] ** 2
    hypotheses, n = covariance_ne.shape
    table = np.empty((PREDICTED, hypotheses, n))
    made = predicted_rows(table)
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
            made.range_m[h, i] = slant
            made.bearing[h, i] = math.atan2(right, ahead)
            made.elevation[h, i] = math.atan2(-below, in_plane)
            made.horizontal[h, i] = horizontal
            made.along[h, i] = north**2 * p_nn + mixed + east**2 * p_ee + (below / slant) ** 2 * vertical
            made.across[h, i] = east**2 * p_nn - mixed + north**2 * p_ee + square * yaw
            made.mixed[h, i] = north * east * (p_ee - p_nn) + (north**2 - east**2) * p_ne
            made.vertical[h, i] = vertical
    return table


def position_measurement(
    echoes: Echoes, vehicle: Vehicle, half_vertical: float, predicted: Floats | None = None
) -> PositionMeasurement:
    """Return eq. 1, z_og = z_ag + R^-1 z_ob, for all echoes, with measurement noise that includes the pose's.

    `predicted`: (m,) elevation at which an object already tracked should be: its echo comes from the nearest one in the
    fan, by default from the fan's middle. `half_vertical`: half the fan's vertical opening, rad.
    """
    elevation = echoes.rows.elevation if predicted is None else predicted
    position, rest = _position_measurement(echoes.table, elevation, vehicle, half_vertical)
    return PositionMeasurement(position, *rest)


@kernel
def _position_measurement(
    table: Floats, predicted: Floats, vehicle: Vehicle, half_vertical: float
) -> tuple[Floats, Floats]:
    """Return (3, m) positions and (6, m) the fields of `PositionMeasurement` after that."""
    echoes, m = echo_rows(table), len(predicted)
    rotation = vehicle.rotation
    s_nn, s_ee = vehicle.sigma_position[0] ** 2, vehicle.sigma_position[1] ** 2
    tilt = max(vehicle.sigma_attitude[0], vehicle.sigma_attitude[1])
    position, rest = np.empty((3, m)), np.empty((6, m))
    variance_north, variance_east, covariance_ne, half_height, radius, radius_variance = rest
    for j in range(m):
        distance, bearing = echoes.range_m[j], echoes.bearing[j]
        middle = echoes.elevation[j]
        elevation = min(max(predicted[j], middle - half_vertical), middle + half_vertical)
        in_plane, below = distance * math.cos(elevation), -distance * math.sin(elevation)
        ahead, right = in_plane * math.cos(bearing), in_plane * math.sin(bearing)
        x = rotation[0, 0] * ahead + rotation[0, 1] * right + rotation[0, 2] * below
        y = rotation[1, 0] * ahead + rotation[1, 1] * right + rotation[1, 2] * below
        # The height measured is that of the fan's middle, wherever in the fan the object is.
        z = rotation[2, 0] * ahead + rotation[2, 1] * right - rotation[2, 2] * distance * math.sin(middle)
        horizontal = max(math.hypot(x, y), NEAREST_M)
        north, east = x / horizontal, y / horizontal
        along = echoes.sigma_range[j] ** 2
        across = horizontal**2 * (echoes.sigma_bearing[j] ** 2 + vehicle.sigma_attitude[2] ** 2)
        position[0, j] = x + vehicle.position[0]
        position[1, j] = y + vehicle.position[1]
        position[2, j] = z + vehicle.position[2]
        variance_north[j] = north**2 * along + east**2 * across + s_nn
        variance_east[j] = east**2 * along + north**2 * across + s_ee
        covariance_ne[j] = north * east * (along - across)
        half_height[j] = distance * math.sin(half_vertical) + vehicle.sigma_position[2] + horizontal * tilt
        radius[j] = echoes.radius[j]
        radius_variance[j] = echoes.sigma_radius[j] ** 2
    return position, rest
