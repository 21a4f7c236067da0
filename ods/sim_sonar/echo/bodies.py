"""The generic objects of [SSIE], and where a ray from the sonar meets them.

sphere    half sizes (radius, radius, radius)
cylinder  local z is the axis, half sizes (radius, radius, half length)
plane     local z is the normal, half sizes (half width, half height, 0); UNBOUNDED without bounds
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats
from ods.sim_sonar.kernel import compiled

SPHERE, CYLINDER, PLANE = 0, 1, 2

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

UNBOUNDED = 1e9
"""Half size of a plane without bounds, m."""
FAR = 1e12
"""Range of a ray that meets nothing, m."""


class LocalRay(NamedTuple):
    """A ray in a body's own axes: where the sonar is, m from the body's centre, and a unit vector along the ray."""

    ox: float
    oy: float
    oz: float
    dx: float
    dy: float
    dz: float


@compiled
def hit(body: Body, x: float, y: float, z: float) -> tuple[float, float]:
    """Return range and cos(incidence angle) where the ray along the unit vector (x, y, z) first meets `body`.

    FAR and 0 where it does not; a body around the sonar is not met.
    """
    if body["kind"] == SPHERE:
        return _hit_sphere(body, x, y, z)
    ray = _local_ray(body["axes"], body["centre"], x, y, z)
    half = body["half"]
    if body["kind"] == CYLINDER:
        return _hit_cylinder(half[0], half[2], ray)
    return _hit_plane(half[0], half[1], ray)


@compiled
def _local_ray(axes: Floats, centre: Floats, x: float, y: float, z: float) -> LocalRay:
    cx, cy, cz = centre[0], centre[1], centre[2]
    return LocalRay(
        ox=-(axes[0, 0] * cx + axes[0, 1] * cy + axes[0, 2] * cz),
        oy=-(axes[1, 0] * cx + axes[1, 1] * cy + axes[1, 2] * cz),
        oz=-(axes[2, 0] * cx + axes[2, 1] * cy + axes[2, 2] * cz),
        dx=axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z,
        dy=axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z,
        dz=axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z,
    )


@compiled
def _hit_sphere(body: Body, x: float, y: float, z: float) -> tuple[float, float]:
    centre = body["centre"]
    cx, cy, cz = centre[0], centre[1], centre[2]
    radius = body["half"][0]
    along = cx * x + cy * y + cz * z
    miss = cx * cx + cy * cy + cz * cz - along * along
    square = radius * radius - miss
    if square <= 0.0 or along <= 0.0:
        return FAR, 0.0
    root = math.sqrt(square)
    distance = along - root
    if distance <= 0.0:
        return FAR, 0.0
    return distance, root / radius


@compiled
def _hit_cylinder(radius: float, half: float, ray: LocalRay) -> tuple[float, float]:
    ox, oy, oz, dx, dy, dz = ray
    a = dx * dx + dy * dy
    b = ox * dx + oy * dy
    square = b * b - a * (ox * ox + oy * oy - radius * radius)
    if a > 1e-12 and square > 0.0:
        root = math.sqrt(square)
        distance = (-b - root) / a
        if distance > 0.0 and abs(oz + distance * dz) <= half:
            return distance, root / radius
    if abs(dz) > 1e-12 and abs(oz) > half:
        cap = math.copysign(half, oz)
        distance = (cap - oz) / dz
        if distance > 0.0:
            px = ox + distance * dx
            py = oy + distance * dy
            if px * px + py * py <= radius * radius:
                return distance, abs(dz)
    return FAR, 0.0


@compiled
def _hit_plane(half_width: float, half_height: float, ray: LocalRay) -> tuple[float, float]:
    ox, oy, oz, dx, dy, dz = ray
    if abs(dz) < 1e-12:
        return FAR, 0.0
    distance = -oz / dz
    if distance <= 0.0 or distance >= FAR:
        return FAR, 0.0
    if abs(ox + distance * dx) > half_width or abs(oy + distance * dy) > half_height:
        return FAR, 0.0
    return distance, abs(dz)


def contains(body: Body, point: Floats) -> bool:
    """Tell whether a sphere or cylinder surrounds `point` (3,); planes surround nothing."""
    local = np.abs(body["axes"] @ (point - body["centre"]))
    radius, _, half_length = body["half"]
    if body["kind"] == PLANE:
        return False
    if body["kind"] == SPHERE:
        return bool(np.linalg.norm(local) <= radius)
    return bool(math.hypot(local[0], local[1]) <= radius and local[2] <= half_length)


@compiled
def middles(bodies: Bodies, point: Floats) -> Floats:
    """Return the (n, 3) points in the middle of bodies that are nearest to `point` (3,).

    A sphere's centre; of a cylinder's axis and of a plane the nearest point. Frame as that of `bodies`.
    """
    out = np.empty((len(bodies), 3))
    for k in range(len(bodies)):
        body = bodies[k]
        centre = body["centre"]
        for c in range(3):
            out[k, c] = centre[c]
        x, y, z = point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]
        for axis in range(3):
            if body["kind"] == SPHERE or (body["kind"] == CYLINDER and axis < 2):
                continue
            axes, half = body["axes"], body["half"][axis]
            along = min(max(axes[axis, 0] * x + axes[axis, 1] * y + axes[axis, 2] * z, -half), half)
            for c in range(3):
                out[k, c] += along * axes[axis, c]
    return out


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


@compiled
def bounding_radius(body: Body) -> float:
    """Return the radius of a body's bounding sphere."""
    across, side, along = body["half"][0], body["half"][1], body["half"][2]
    if body["kind"] == SPHERE:
        return float(across)
    if body["kind"] == CYLINDER:
        return math.hypot(across, along)
    return math.hypot(across, side)


def to_sonar_frame(bodies: Bodies, position_ned: Floats, rotation: Floats) -> Bodies:
    """Return bodies given in NED as seen by a sonar at `position_ned` with body-to-global `rotation` (3, 3)."""
    seen = bodies.copy()
    seen["centre"] = (bodies["centre"] - position_ned) @ rotation
    seen["axes"] = bodies["axes"] @ rotation
    return seen
