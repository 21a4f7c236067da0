"""One attitude as a unit quaternion (w, x, y, z) in plain floats: for one, five to twenty times faster than numpy.

`ods.base.frames.geometry` has the same for arrays. Both turn body vectors into global ones, or one frame's into
another's.
"""

import math

Quaternion = tuple[float, float, float, float]
Vector3 = tuple[float, float, float]


def from_euler(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return what `ods.base.frames.geometry.quat_from_euler` does; rad."""
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the attitude that turns by `b` first and by `a` then."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def conjugate(q: Quaternion) -> Quaternion:
    """Return the attitude that turns back."""
    return q[0], -q[1], -q[2], -q[3]


def turn_between(a: Quaternion, b: Quaternion) -> float:
    """Return the angle between two attitudes, about whatever axis, rad."""
    cosine = abs(sum(p * q for p, q in zip(a, b, strict=True)))
    return 2.0 * math.acos(min(cosine, 1.0))


def rotated(q: Quaternion, v: Vector3) -> Vector3:
    """Return the body vector v in the global frame: v + 2 u x (u x v + w v), u the vector part of q."""
    w, x, y, z = q
    cx = y * v[2] - z * v[1] + w * v[0]
    cy = z * v[0] - x * v[2] + w * v[1]
    cz = x * v[1] - y * v[0] + w * v[2]
    return v[0] + 2.0 * (y * cz - z * cy), v[1] + 2.0 * (z * cx - x * cz), v[2] + 2.0 * (x * cy - y * cx)


def slerp(a: Quaternion, b: Quaternion, f: float) -> Quaternion:
    """Return the unit quaternion at the fraction `f` of the shorter arc from a to b; f above 1 extrapolates."""
    cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    sign = 1.0 if cosine >= 0.0 else -1.0
    arc = math.acos(min(cosine * sign, 1.0))
    if arc < 1e-6:  # its sine is too small to divide by, and a straight line as good
        p, q = 1.0 - f, f * sign
    else:
        p, q = math.sin((1.0 - f) * arc), math.sin(f * arc) * sign
    w, x, y, z = p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2], p * a[3] + q * b[3]
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    return w / norm, x / norm, y / norm, z / norm
