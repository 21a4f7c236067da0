"""The generic objects of [SSIE], and where a ray from the sonar meets them.

sphere    half sizes (radius, radius, radius)
cylinder  local z is the axis, half sizes (radius, radius, half length)
plane     local z is the normal, half sizes (half width, half height, 0); UNBOUNDED without bounds
"""

import math

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats
from ods.compiled import native

SPHERE, CYLINDER, PLANE = range(3)

BODY = np.dtype(
    [
        ("kind", np.int64),
        ("centre", np.float64, 3),
        ("axes", np.float64, (3, 3)),
        ("half", np.float64, 3),
        ("cd", np.float64),
        ("cs", np.float64),
        ("sigma_rad", np.float64),
    ]
)
"""One body: SPHERE, CYLINDER or PLANE; its centre, m; its local axes, the rows of a rotation matrix; half sizes, m; its
surface (see reflection)."""
Bodies = NDArray[np.void]
"""(n,) of BODY, all in NED or in the sonar's frame (FRD, origin at the sonar)."""
Body = np.void
"""One of them."""

_EXTENDED = np.array([(False, False, False), (False, False, True), (True, True, True)])
"""By kind of body: along which axes its middle extends."""
UNBOUNDED = 1e9
"""Half size of a plane without bounds, m."""
FAR: float = native.far_m()
"""Range of a ray that meets nothing, m."""


def hit(body: Body, x: float, y: float, z: float) -> tuple[float, float]:
    """Return range and cos(incidence angle) where the ray along the unit vector (x, y, z) first meets `body`.

    FAR and 0 where it does not; a body around the sonar is not met.
    """
    met = np.empty(2)
    native.hit_body(np.asarray(body).reshape(1), x, y, z, met)
    return float(met[0]), float(met[1])


def contains(body: Body, point: Floats) -> bool:
    """Return whether a sphere or cylinder surrounds `point` (3,); planes surround nothing."""
    local = np.abs(body["axes"] @ (point - body["centre"]))
    radius, _, half_length = body["half"]
    if body["kind"] == PLANE:
        return False
    if body["kind"] == SPHERE:
        return bool(np.linalg.norm(local) <= radius)
    return bool(math.hypot(local[0], local[1]) <= radius and local[2] <= half_length)


def clearances(bodies: Bodies, point: Floats) -> Floats:
    """Return (n,) the distance from `point` (3,) to each body's surface, m; below 0 inside a sphere or cylinder."""
    local = np.abs((bodies["axes"] @ (point - bodies["centre"])[:, :, None])[:, :, 0])
    half, across = bodies["half"], np.hypot(local[:, 0], local[:, 1])
    beyond = np.stack([across - half[:, 0], local[:, 2] - half[:, 2]], axis=-1)
    cylinder = np.hypot(*np.maximum(beyond, 0.0).T) + np.minimum(beyond.max(axis=1), 0.0)
    plane = np.linalg.norm(np.maximum(local - half, 0.0), axis=1)
    sphere = np.linalg.norm(local, axis=1) - half[:, 0]
    return np.select([bodies["kind"] == SPHERE, bodies["kind"] == CYLINDER], [sphere, cylinder], plane)


def middles(bodies: Bodies, point: Floats) -> Floats:
    """Return the (n, 3) points in the middle of bodies that are nearest to `point` (3,).

    A sphere's centre; of a cylinder's axis and of a plane the nearest point. Frame as that of `bodies`.
    """
    centre, axes = bodies["centre"], bodies["axes"]
    half = np.where(_EXTENDED[bodies["kind"]], bodies["half"], 0.0)
    along = np.clip((axes @ (point - centre)[:, :, None])[:, :, 0], -half, half)
    return np.asarray(centre + (along[:, None, :] @ axes)[:, 0])


def circle_radius(body: Body) -> float:
    """Return the radius of the circle that circumscribes a body's projection on the frame's x-y plane."""
    axes, half = body["axes"], body["half"]
    if body["kind"] == SPHERE:
        return float(half[0])
    if body["kind"] == PLANE:
        sides = axes[:2, :2] * half[:2, None]
        return float(max(np.linalg.norm(sides[0] + sides[1]), np.linalg.norm(sides[0] - sides[1])))
    return _cylinder_circle(float(half[0]), float(half[2]), min(1.0, abs(float(axes[2, 2]))))


def _cylinder_circle(radius: float, half: float, upright: float) -> float:
    """Farthest point of a cap's ellipse, semi-axes radius and radius * upright, shifted along the latter."""
    shift, semi = half * math.sqrt(1.0 - upright * upright), radius * upright
    squeeze = radius * radius - semi * semi
    cosine = min(1.0, shift * semi / squeeze) if squeeze > 1e-12 else 1.0
    return math.sqrt((shift + semi * cosine) ** 2 + radius * radius * (1.0 - cosine * cosine))


def to_sonar_frame(bodies: Bodies, position_ned: Floats, rotation: Floats) -> Bodies:
    """Return bodies given in NED as seen by a sonar at `position_ned` with body-to-global `rotation` (3, 3)."""
    seen = bodies.copy()
    seen["centre"] = (bodies["centre"] - position_ned) @ rotation
    seen["axes"] = bodies["axes"] @ rotation
    return seen
