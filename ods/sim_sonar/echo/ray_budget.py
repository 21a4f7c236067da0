"""How many rays each object needs, and which objects may hide which."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.sim_sonar.echo.bodies import PLANE, SPHERE, Bodies, Body, bounding_radius
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import LIT_BEYOND_WIDTHS, Grid, mean_two_way

MAX_CELLS = 720
"""Of one object in bearing, or in elevation."""
ALL_ROUND = (-math.pi, math.pi, -0.5 * math.pi, 0.5 * math.pi)
LOOSEST = 4.0
"""Error that a faint object's own echo may have, over that of the image."""


class RayFan(NamedTuple):
    """The rays for one object: borders of their cells, empty when nothing of it can be seen."""

    bearing: Floats
    elevation: Floats
    farthest_m: float
    """Range, m, beyond which nothing of the object lies."""


@compiled
def shares_of_error(seen: Bodies, grid: Grid, max_error: float) -> Floats:
    """Return the (n,) relative errors that the echoes of (n,) bodies in the sonar's frame may have.

    Together they make `max_error`. An echo that fills n samples with the power a counts for a / sqrt(n) in the image's
    rms, its rays cost as one over its error: least work is where the error goes as that to the power -2/3. Planes keep
    `max_error`.
    """
    out = np.full(len(seen), max_error)
    weight = np.zeros(len(seen))
    for k in range(len(seen)):
        if seen[k]["kind"] != PLANE:
            weight[k] = _weight(seen[k], grid)
    total, parts = np.sum(weight**2), np.sum(weight ** (2.0 / 3.0))
    for k in range(len(seen)):
        if weight[k] > 0.0:
            share = math.sqrt(total / parts) / weight[k] ** (2.0 / 3.0)
            out[k] = max_error * min(share, LOOSEST)
    return out


@compiled
def _weight(body: Body, grid: Grid) -> float:
    """Return about how much a sphere or cylinder counts in the rms of the image."""
    x, y, z = body["centre"][0], body["centre"][1], body["centre"][2]
    half = body["half"]
    radius = math.sqrt(half[0] * max(half[0], half[2]))
    distance = max(math.sqrt(x * x + y * y + z * z), radius)
    sine, reach = -z / distance, radius / distance
    heard = 0.0
    for plane in range(len(grid.vertical)):
        heard += mean_two_way(grid.vertical[plane], max(sine - reach, -1.0), min(sine + reach, 1.0))
    samples = max(1.0, radius / grid.dr_m) * max(1.0, 2.0 * reach / grid.beam_width_rad)
    return float((body["cd"] + body["cs"]) * heard * radius * radius / math.sqrt(samples))


@compiled
def ray_fan_of(bodies: Bodies, which: int, grid: Grid, max_error: float) -> RayFan:
    """Return the rays that hold what the sonar can see of a body, fine enough for a relative error of `max_error`."""
    body = bodies[which]
    nothing = RayFan(np.empty(0), np.empty(0), 0.0)
    nearest, farthest = _reach(body)
    if nearest > grid.edge_m + grid.samples * grid.dr_m:
        return nothing
    low, high, bottom, top = _span(body)
    margin = LIT_BEYOND_WIDTHS * grid.beam_width_rad
    low, high = max(low, grid.bearing_rad[0] - margin), min(high, grid.bearing_rad[-1] + margin)
    if low >= high:
        return nothing
    finest = 3.3 / math.sqrt(max_error)
    beam_cells = (high - low) / (grid.beam_width_rad * min(0.5, 3.0 * math.sqrt(max_error)))
    if body["kind"] == PLANE:
        lobes = 1.7 * finest / body["sigma_rad"] / math.pi
        across, upward = (high - low) * lobes, (top - bottom) * lobes
    else:
        across = upward = 0.33 * finest / body["sigma_rad"]
    return RayFan(
        _borders(low, high, max(finest, beam_cells, across)),
        _borders(bottom, top, max(finest, upward)),
        farthest,
    )


@compiled
def rivals_of(seen: Bodies) -> Mask:
    """Return (n, n): whether, of (n,) bodies in the sonar's frame, the second may stand before the first."""
    count = len(seen)
    out = np.zeros((count, count), np.bool_)
    distance, radius, half = np.empty(count), np.empty(count), np.empty(count)
    place = np.empty((count, 3))
    for k in range(count):
        centre = seen[k]["centre"]
        x, y, z = centre[0], centre[1], centre[2]
        place[k, 0], place[k, 1], place[k, 2] = x, y, z
        distance[k] = math.sqrt(x * x + y * y + z * z)
        radius[k] = bounding_radius(seen[k])
        half[k] = math.asin(radius[k] / distance[k]) if distance[k] > radius[k] else math.pi
    for k in range(count):
        for other in range(count):
            if other == k or distance[other] - radius[other] >= distance[k] + radius[k]:
                continue
            apart = math.pi
            if distance[k] * distance[other] > 0.0:
                product = 0.0
                for c in range(3):
                    product += place[k, c] * place[other, c]
                apart = math.acos(min(max(product / (distance[k] * distance[other]), -1.0), 1.0))
            out[k, other] = apart < half[k] + half[other]
    return out


@compiled
def _reach(body: Body) -> tuple[float, float]:
    """Return ranges, m, between which all of a body lies."""
    x, y, z = body["centre"][0], body["centre"][1], body["centre"][2]
    distance, radius = math.sqrt(x * x + y * y + z * z), bounding_radius(body)
    return distance - radius, distance + radius


@compiled
def _borders(low: float, high: float, wanted: float) -> Floats:
    """Return the borders of about `wanted` even cells."""
    cells = min(MAX_CELLS, max(2, math.ceil(wanted)))
    return np.arange(0.0, cells + 1.0) * ((high - low) / cells) + low


@compiled
def _span(body: Body) -> tuple[float, float, float, float]:
    """Return least and greatest bearing, least and greatest elevation of a body; all round when it cannot be told."""
    if body["kind"] != SPHERE:
        return _box_span(body)
    x, y, z = body["centre"][0], body["centre"][1], body["centre"][2]
    radius = body["half"][0]
    level, distance = math.hypot(x, y), math.sqrt(x * x + y * y + z * z)
    if level <= radius:
        return ALL_ROUND
    bearing, across = math.atan2(y, x), math.asin(radius / level)
    elevation, upward = math.atan2(-z, level), math.asin(radius / distance)
    return bearing - across, bearing + across, elevation - upward, elevation + upward


@compiled
def _box_span(body: Body) -> tuple[float, float, float, float]:
    west, east, bottom, top = math.pi, -math.pi, math.pi, -math.pi
    place = np.empty(3)
    for point in _BOX_EDGES:
        for c in range(3):
            place[c] = body["centre"][c]
            for axis in range(3):
                place[c] += point[axis] * body["half"][axis] * body["axes"][axis, c]
        if place[0] <= 0.0:
            return ALL_ROUND
        bearing = math.atan2(place[1], place[0])
        elevation = math.atan2(-place[2], math.hypot(place[0], place[1]))
        west, east = min(west, bearing), max(east, bearing)
        bottom, top = min(bottom, elevation), max(top, elevation)
    return west, east, bottom, top


def _box_edges() -> Floats:
    """Return points along the edges of the cube [-1, 1]^3, where bearing and elevation of a box are extreme."""
    along = np.linspace(-1.0, 1.0, 17)
    return np.array(
        [np.roll([x, y, z], axis) for axis in range(3) for x in along for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
    )


_BOX_EDGES = _box_edges()
