"""The generic objects of [SSIE] as rows of numbers, and where a ray from the sonar meets them.

A body is one row of COLUMNS float64, in the sonar's frame (FRD, origin at the sonar): kind, centre, local axes (three
rows of a rotation matrix), half sizes, Cd, Cs, sigma in radians.
    sphere    half sizes (radius, radius, radius)
    cylinder  local z is the axis, half sizes (radius, radius, half length)
    plane     local z is the normal, half sizes (half width, half height, 0); UNBOUNDED without bounds
"""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.kernel import compiled

SPHERE, CYLINDER, PLANE = 0, 1, 2
KIND, CENTRE, AXES, HALF, SURFACE, COLUMNS = 0, 1, 4, 13, 16, 19

UNBOUNDED = 1e9
"""Half size of a plane without bounds, m."""
FAR = 1e12
"""Range of a ray that meets nothing, m."""


@compiled
def hit(body: Floats, x: float, y: float, z: float) -> tuple[float, float]:
    """Return range and cos(incidence angle) where the ray along the unit vector (x, y, z) first meets `body`.

    FAR and 0 where it does not; a body around the sonar is not met.
    """
    if body[KIND] == SPHERE:
        return _hit_sphere(body, x, y, z)
    a, h = AXES, HALF
    dx = body[a] * x + body[a + 1] * y + body[a + 2] * z
    dy = body[a + 3] * x + body[a + 4] * y + body[a + 5] * z
    dz = body[a + 6] * x + body[a + 7] * y + body[a + 8] * z
    cx, cy, cz = body[CENTRE], body[CENTRE + 1], body[CENTRE + 2]
    ox = -(body[a] * cx + body[a + 1] * cy + body[a + 2] * cz)
    oy = -(body[a + 3] * cx + body[a + 4] * cy + body[a + 5] * cz)
    oz = -(body[a + 6] * cx + body[a + 7] * cy + body[a + 8] * cz)
    if body[KIND] == CYLINDER:
        return _hit_cylinder(body[h], body[h + 2], ox, oy, oz, dx, dy, dz)
    return _hit_plane(body[h], body[h + 1], ox, oy, oz, dx, dy, dz)


@compiled
def _hit_sphere(body: Floats, x: float, y: float, z: float) -> tuple[float, float]:
    cx, cy, cz = body[CENTRE], body[CENTRE + 1], body[CENTRE + 2]
    radius = body[HALF]
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
def _hit_cylinder(
    radius: float, half: float, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float
) -> tuple[float, float]:
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
def _hit_plane(
    half_width: float, half_height: float, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float
) -> tuple[float, float]:
    if abs(dz) < 1e-12:
        return FAR, 0.0
    distance = -oz / dz
    if distance <= 0.0 or distance >= FAR:
        return FAR, 0.0
    if abs(ox + distance * dx) > half_width or abs(oy + distance * dy) > half_height:
        return FAR, 0.0
    return distance, abs(dz)


def contains(body: Floats, point: Floats) -> bool:
    """Tell whether a sphere or cylinder surrounds `point` (3,); planes surround nothing."""
    axes = body[AXES:HALF].reshape(3, 3)
    local = np.abs(axes @ (point - body[CENTRE:AXES]))
    if body[KIND] == PLANE:
        return False
    if body[KIND] == SPHERE:
        return bool(np.linalg.norm(local) <= body[HALF])
    return bool(math.hypot(local[0], local[1]) <= body[HALF] and local[2] <= body[HALF + 2])


@compiled
def middles(bodies: Floats, point: Floats) -> Floats:
    """Return the (n, 3) points in the middle of bodies that are nearest to `point` (3,).

    A sphere's centre; of a cylinder's axis and of a plane the nearest point. Frame as that of `bodies`.
    """
    out = bodies[:, CENTRE:AXES].copy()
    for k in range(len(bodies)):
        body = bodies[k]
        x, y, z = point[0] - body[CENTRE], point[1] - body[CENTRE + 1], point[2] - body[CENTRE + 2]
        for axis in range(3):
            if body[KIND] == SPHERE or (body[KIND] == CYLINDER and axis < 2):
                continue
            a, half = AXES + 3 * axis, body[HALF + axis]
            along = min(max(body[a] * x + body[a + 1] * y + body[a + 2] * z, -half), half)
            for c in range(3):
                out[k, c] += along * body[a + c]
    return out


def circle_radius(body: Floats) -> float:
    """Return the radius of the circle that circumscribes a body's projection on the frame's x-y plane."""
    axes = body[AXES:HALF].reshape(3, 3)
    half = body[HALF:SURFACE]
    if body[KIND] == SPHERE:
        return float(half[0])
    if body[KIND] == PLANE:
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
def bounding_radius(body: Floats) -> float:
    """Return the radius of a body's bounding sphere."""
    across, side, along = body[HALF], body[HALF + 1], body[HALF + 2]
    if body[KIND] == SPHERE:
        return float(across)
    if body[KIND] == CYLINDER:
        return math.hypot(across, along)
    return math.hypot(across, side)


def to_sonar_frame(bodies: Floats, position_ned: Floats, rotation: Floats) -> Floats:
    """Return bodies given in NED as seen by a sonar at `position_ned` with body-to-global `rotation` (3, 3)."""
    seen = bodies.copy()
    seen[:, CENTRE:AXES] = (bodies[:, CENTRE:AXES] - position_ned) @ rotation
    seen[:, AXES:HALF] = (bodies[:, AXES:HALF].reshape(-1, 3, 3) @ rotation).reshape(-1, 9)
    return seen
