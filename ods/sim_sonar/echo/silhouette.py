"""The outline of a body as the sonar sees it: its bearings, and its elevations at one bearing.

The half plane of a bearing cuts a convex body in one piece, and so rays at that bearing meet it between two elevations.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.bodies import CYLINDER, SPHERE, Body
from ods.sim_sonar.kernel import compiled

RIGHT = 0.5 * math.pi
ALL_ROUND = (-math.pi, math.pi)
NOTHING = (1.0, -1.0)
"""Least above greatest: there is none."""
TINY = 1e-12


class Cut(NamedTuple):
    """The half plane of a bearing in a body's own axes: where the sonar is, unit vectors ahead and up; (3,) each."""

    origin: Floats
    ahead: Floats
    up: Floats


class CutLine(NamedTuple):
    """Where the half plane meets a plane of the body's: its place nearest to the sonar, m ahead and up, and way on."""

    place: tuple[float, float]
    way: tuple[float, float]
    """Unit vector."""


@compiled
def bearing_marks(body: Body) -> Floats:
    """Return the bearings, rad, rising, at which a body in the sonar's frame begins, has corners or rims, and ends.

    (n,); all round when they cannot be told.
    """
    if body["kind"] == SPHERE:
        x, y, radius = body["centre"][0], body["centre"][1], body["half"][0]
        level = math.hypot(x, y)
        if level <= radius:
            return np.array(ALL_ROUND)
        bearing, across = math.atan2(y, x), math.asin(radius / level)
        return np.array([bearing - across, bearing + across])
    points = _rims(body) if body["kind"] == CYLINDER else _corners(body)
    if not (points[:, 0].min() > 0.0 or points[:, 1].min() > 0.0 or points[:, 1].max() < 0.0):
        return np.array(ALL_ROUND)
    return np.sort(np.arctan2(points[:, 1], points[:, 0]))


@compiled
def elevation_span(body: Body, bearing_rad: float, farthest_m: float) -> tuple[float, float]:
    """Return least and greatest elevation of a body at one bearing, rad, within half a turn; NOTHING: it is not there.

    Of a plane, what is nearer than `farthest_m`. The body may hide the lower part from view, never the ends.
    """
    cut = _cut(body, bearing_rad)
    if body["kind"] == SPHERE:
        return _sphere_span(cut, body["half"][0])
    if body["kind"] == CYLINDER:
        return _cylinder_span(cut, body["half"][0], body["half"][2])
    return _plane_span(cut, body["half"][0], body["half"][1], farthest_m)


@compiled
def _cut(body: Body, bearing_rad: float) -> Cut:
    axes, centre = body["axes"], body["centre"]
    cosine, sine = math.cos(bearing_rad), math.sin(bearing_rad)
    origin, ahead, up = np.empty(3), np.empty(3), np.empty(3)
    for k in range(3):
        origin[k] = -(axes[k, 0] * centre[0] + axes[k, 1] * centre[1] + axes[k, 2] * centre[2])
        ahead[k] = axes[k, 0] * cosine + axes[k, 1] * sine
        up[k] = -axes[k, 2]
    return Cut(origin, ahead, up)


@compiled
def _line(cut: Cut, at: float) -> CutLine:
    """Return where the body's third coordinate is `at`; the half plane must not be parallel to that plane."""
    a, b = cut.ahead[2], cut.up[2]
    norm = math.hypot(a, b)
    share = (at - cut.origin[2]) / (norm * norm)
    return CutLine((a * share, b * share), (-b / norm, a / norm))


@compiled
def _along(cut: Cut, line: CutLine, axis: int) -> tuple[float, float]:
    """Return a coordinate in the body's axes at the line's place, and its change along the line."""
    ahead, up = cut.ahead[axis], cut.up[axis]
    there = cut.origin[axis] + ahead * line.place[0] + up * line.place[1]
    return there, ahead * line.way[0] + up * line.way[1]


@compiled
def _sphere_span(cut: Cut, radius: float) -> tuple[float, float]:
    along = up = square = 0.0
    for k in range(3):
        along -= cut.origin[k] * cut.ahead[k]
        up -= cut.origin[k] * cut.up[k]
        square += cut.origin[k] ** 2
    inside = radius * radius - (square - along * along - up * up)
    distance = math.hypot(along, up)
    if inside <= 0.0 or distance * distance <= inside:
        return NOTHING
    middle, half = math.atan2(up, along), math.asin(math.sqrt(inside) / distance)
    return max(middle - half, -RIGHT), min(middle + half, RIGHT)


@compiled
def _cylinder_span(cut: Cut, radius: float, half: float) -> tuple[float, float]:
    """The ends are where rays touch the side, or on the rims."""
    low, high = _touching(cut, radius, half)
    if math.hypot(cut.ahead[2], cut.up[2]) < TINY:
        return low, high
    above = below = False
    for side in (-1.0, 1.0):
        line = _line(cut, side * half)
        (x, dx), (y, dy) = _along(cut, line, 0), _along(cut, line, 1)
        middle = x * dx + y * dy
        square = middle * middle - (x * x + y * y - radius * radius)
        for end in (-1.0, 1.0):
            if square > 0.0:
                step = end * math.sqrt(square) - middle
                ahead, up = line.place[0] + step * line.way[0], line.place[1] + step * line.way[1]
                if ahead > 0.0:
                    low, high = min(low, math.atan2(up, ahead)), max(high, math.atan2(up, ahead))
                above, below = above or (ahead <= 0.0 < up), below or (ahead <= 0.0 and up < 0.0)
    if low < high:
        low, high = -RIGHT if below else low, RIGHT if above else high
    return low, high


@compiled
def _touching(cut: Cut, radius: float, half: float) -> tuple[float, float]:
    """Return least and greatest elevation of the rays that touch a cylinder's side; (RIGHT, -RIGHT) for none."""
    ox, oy, oz = cut.origin[0], cut.origin[1], cut.origin[2]
    ux, uy, uz = cut.ahead[0], cut.ahead[1], cut.ahead[2]
    vx, vy, vz = cut.up[0], cut.up[1], cut.up[2]
    over_u, over_v, square = ox * uy - oy * ux, ox * vy - oy * vx, radius * radius
    a = over_v * over_v - square * (vx * vx + vy * vy)
    b = over_u * over_v - square * (ux * vx + uy * vy)
    c = over_u * over_u - square * (ux * ux + uy * uy)
    low, high, rest = RIGHT, -RIGHT, b * b - a * c
    for side in (-1.0, 1.0):
        if rest <= 0.0:
            continue
        ahead, up = abs(a), math.copysign(1.0, a) * (side * math.sqrt(rest) - b)
        dx, dy, dz = ahead * ux + up * vx, ahead * uy + up * vy, ahead * uz + up * vz
        share = -(ox * dx + oy * dy) / max(dx * dx + dy * dy, 1e-300)
        if share > 0.0 and abs(oz + share * dz) <= half:
            low, high = min(low, math.atan2(up, ahead)), max(high, math.atan2(up, ahead))
    return low, high


@compiled
def _plane_span(cut: Cut, half_width: float, half_height: float, farthest_m: float) -> tuple[float, float]:
    """Clip the line that the half plane cuts from the plane."""
    if math.hypot(cut.ahead[2], cut.up[2]) < TINY:
        return NOTHING
    line = _line(cut, 0.0)
    reach = farthest_m**2 - line.place[0] ** 2 - line.place[1] ** 2
    if reach <= 0.0:
        return NOTHING
    begin, end = -math.sqrt(reach), math.sqrt(reach)
    x, y = _along(cut, line, 0), _along(cut, line, 1)
    for at, change, half in ((x[0], x[1], half_width), (y[0], y[1], half_height)):
        if abs(change) < TINY:
            if abs(at) > half:
                return NOTHING
            continue
        one, other = (-half - at) / change, (half - at) / change
        begin, end = max(begin, min(one, other)), min(end, max(one, other))
    if abs(line.way[0]) > TINY:  # nothing of what is behind
        if line.way[0] > 0.0:
            begin = max(begin, -line.place[0] / line.way[0])
        else:
            end = min(end, -line.place[0] / line.way[0])
    elif line.place[0] < 0.0:
        return NOTHING
    if begin >= end:
        return NOTHING
    one = math.atan2(line.place[1] + begin * line.way[1], max(line.place[0] + begin * line.way[0], 0.0))
    other = math.atan2(line.place[1] + end * line.way[1], max(line.place[0] + end * line.way[0], 0.0))
    return min(one, other), max(one, other)


@compiled
def _corners(body: Body) -> Floats:
    """Return the (4, 2) corners of a plane, seen from above."""
    out, count = np.empty((4, 2)), 0
    axes, half = body["axes"], body["half"]
    for x in (-half[0], half[0]):
        for y in (-half[1], half[1]):
            for c in range(2):
                out[count, c] = body["centre"][c] + x * axes[0, c] + y * axes[1, c]
            count += 1
    return out


@compiled
def _rims(body: Body) -> Floats:
    """Return the (4, 2) places, seen from above, where bearings touch a cylinder's rims; (-1, 0) if they do not."""
    out, count = np.empty((4, 2)), 0
    axes, radius = body["axes"], body["half"][0]
    ux, uy, vx, vy = radius * axes[0, 0], radius * axes[0, 1], radius * axes[1, 0], radius * axes[1, 1]
    for side in (-body["half"][2], body["half"][2]):
        x, y = body["centre"][0] + side * axes[2, 0], body["centre"][1] + side * axes[2, 1]
        a, b, c = x * vy - y * vx, y * ux - x * uy, uy * vx - ux * vy
        norm = math.hypot(a, b)
        for way in (-1.0, 1.0):
            out[count, 0], out[count, 1] = -1.0, 0.0
            if norm > abs(c):
                turn = math.atan2(b, a) + way * math.acos(c / norm)
                out[count, 0] = x + ux * math.cos(turn) + vx * math.sin(turn)
                out[count, 1] = y + uy * math.cos(turn) + vy * math.sin(turn)
            count += 1
    return out
