"""Frames and rotations: body FRD, world NED, eq. 1 of [SSIE], polar and Cartesian coordinates.

Attitude is a unit quaternion (w, x, y, z) that turns body vectors into global ones; the R of eq. 1 turns global into
body, so R^-1 is `rotation_matrix(q)`. Euler angles (roll, pitch, yaw: z-y-x order) appear only at the edges.
[SSIE] L. Henriksen, IEEE AUV Symposium 1996, pp. 333-340.
"""

import math
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ods.base.arrays import Floats


def wrap_angle(angle_rad: ArrayLike) -> Floats:
    """Return angles wrapped to [-pi, pi), same shape."""
    return (np.asarray(angle_rad, np.float64) + np.pi) % (2.0 * np.pi) - np.pi


def quat_from_euler(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> Floats:
    """Return the (..., 4) body-to-global quaternion of z-y-x Euler angles in radians."""
    half = 0.5 * np.stack(np.broadcast_arrays(roll, pitch, yaw), axis=-1).astype(np.float64)
    cr, cp, cy = np.moveaxis(np.cos(half), -1, 0)
    sr, sp, sy = np.moveaxis(np.sin(half), -1, 0)
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=-1,
    )


def euler_from_quat(q: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Return roll, pitch, yaw in radians of (..., 4) quaternions; at pitch +-90 deg all turn is put into yaw."""
    w, x, y, z = np.moveaxis(np.asarray(q, np.float64), -1, 0)
    sin_pitch = np.clip(2.0 * (w * y - z * x), -1.0, 1.0)
    locked = np.abs(sin_pitch) > 1.0 - 1e-12
    roll = np.where(locked, 0.0, np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)))
    yaw_locked = np.arctan2(-2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z))
    yaw = np.where(locked, yaw_locked, np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
    return roll, np.arcsin(sin_pitch), yaw


def yaw_from_quat(q: Floats) -> float:
    """Return the last of `euler_from_quat` of one quaternion, (4,)."""
    w, x, y, z = q.tolist()
    if abs(2.0 * (w * y - z * x)) > 1.0 - 1e-12:
        return math.atan2(-2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z))
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def rotation_matrix(q: ArrayLike) -> Floats:
    """Return the (..., 3, 3) matrices that turn body vectors into global ones."""
    attitude = np.asarray(q, np.float64)
    if attitude.ndim == 1:  # plain floats: the same numbers, ten times as fast
        return np.array(_rotation_rows(*attitude.tolist()))
    rows = _rotation_rows(*np.moveaxis(attitude, -1, 0))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


NumberT = TypeVar("NumberT", float, Floats)


def _rotation_rows(w: NumberT, x: NumberT, y: NumberT, z: NumberT) -> list[list[NumberT]]:
    return [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]


def polar_to_body(range_m: ArrayLike, bearing_rad: ArrayLike, elevation_rad: ArrayLike = 0.0) -> Floats:
    """Return (..., 3) FRD positions of slant range, bearing (starboard positive) and elevation (up positive)."""
    r, b, e = np.broadcast_arrays(
        np.asarray(range_m, np.float64), np.asarray(bearing_rad, np.float64), np.asarray(elevation_rad, np.float64)
    )
    horizontal = r * np.cos(e)
    return np.stack([horizontal * np.cos(b), horizontal * np.sin(b), -r * np.sin(e)], axis=-1)


def body_to_polar(position_body: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Return slant range, bearing and elevation of (..., 3) FRD positions."""
    x, y, z = np.moveaxis(np.asarray(position_body, np.float64), -1, 0)
    horizontal = np.hypot(x, y)
    return np.hypot(horizontal, z), np.arctan2(y, x), np.arctan2(-z, horizontal)


def body_to_global(position_body: ArrayLike, vehicle_ned: ArrayLike, attitude: ArrayLike) -> Floats:
    """Eq. 1: z_og = z_ag + R^-1 z_ob; (..., 3) FRD to (..., 3) NED for one pose (3,), (4,)."""
    return np.asarray(position_body, np.float64) @ rotation_matrix(attitude).T + np.asarray(vehicle_ned, np.float64)


def global_to_body(position_ned: ArrayLike, vehicle_ned: ArrayLike, attitude: ArrayLike) -> Floats:
    """Eq. 1 solved for the body frame; (..., 3) NED to (..., 3) FRD for one pose (3,), (4,)."""
    return (np.asarray(position_ned, np.float64) - np.asarray(vehicle_ned, np.float64)) @ rotation_matrix(attitude)
