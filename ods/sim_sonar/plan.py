"""How fine each object's fan must be, and which objects may hide which."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.sim_sonar import bodies
from ods.sim_sonar.grid import Grid

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

MARGIN_WIDTHS = 3.0
"""The projector lights this many beam widths beyond the outer beams."""
MAX_CELLS = 720
"""Cells of a fan in bearing, or in elevation."""
ALL_ROUND = (-math.pi, math.pi, -0.5 * math.pi, 0.5 * math.pi)


class Fan(NamedTuple):
    """Borders of the cells of one object's fan; empty when nothing of it can be seen."""

    bearing: Array
    elevation: Array
    farthest_m: float
    """Range, m, beyond which nothing of the object lies."""


def fan_of(body: Array, grid: Grid, max_error: float) -> Fan:
    """Return the fan that holds what the sonar can see of `body`, fine enough for a relative error of `max_error`."""
    nothing = Fan(np.empty(0), np.empty(0), 0.0)
    nearest, farthest = _reach(body)
    if nearest > grid.edge_m + grid.samples * grid.dr_m:
        return nothing
    low, high, bottom, top = _span(body)
    margin = MARGIN_WIDTHS * grid.beam_width_rad
    low, high = max(low, grid.bearing_rad[0] - margin), min(high, grid.bearing_rad[-1] + margin)
    if low >= high:
        return nothing
    finest = 4.0 / math.sqrt(max_error)
    beam_cells = (high - low) / (grid.beam_width_rad * min(0.5, 3.0 * math.sqrt(max_error)))
    if body[bodies.KIND] == bodies.PLANE:
        lobes = 1.7 * finest / body[bodies.SURFACE + 2] / math.pi
        across, upward = (high - low) * lobes, (top - bottom) * lobes
    else:
        across = upward = 0.33 * finest / body[bodies.SURFACE + 2]
    return Fan(
        _borders(low, high, max(finest, beam_cells, across)),
        _borders(bottom, top, max(finest, upward)),
        farthest,
    )


def rivals_of(seen: Array) -> list[Indices]:
    """Return, for each of (n, COLUMNS) bodies in the sonar's frame, which others may stand before it."""
    centre, radius = seen[:, bodies.CENTRE : bodies.AXES], bodies.bounding_radius(seen)
    distance = np.linalg.norm(centre, axis=1)
    around = distance <= radius
    safe = np.where(around, 1.0, distance)
    half = np.where(around, math.pi, np.arcsin(np.where(around, 0.0, radius / safe)))
    cosine = np.clip((centre @ centre.T) / np.outer(safe, safe), -1.0, 1.0)
    meet = np.arccos(cosine) < half[:, None] + half[None, :]
    nearer = (distance - radius)[None, :] < (distance + radius)[:, None]
    np.fill_diagonal(meet, False)
    return [np.flatnonzero(row) for row in meet & nearer]


def _reach(body: Array) -> tuple[float, float]:
    """Return ranges, m, between which all of a body lies."""
    x, y, z = body[bodies.CENTRE : bodies.AXES]
    distance, radius = math.sqrt(x * x + y * y + z * z), math.hypot(*body[bodies.HALF : bodies.SURFACE])
    return distance - radius, distance + radius


def _borders(low: float, high: float, wanted: float) -> Array:
    """Return the borders of about `wanted` even cells."""
    cells = min(MAX_CELLS, max(2, math.ceil(wanted)))
    return np.asarray(np.arange(cells + 1) * ((high - low) / cells) + low, np.float64)


def _span(body: Array) -> tuple[float, float, float, float]:
    """Return least and greatest bearing, least and greatest elevation of a body; all round when it cannot be told."""
    centre, half = body[bodies.CENTRE : bodies.AXES], body[bodies.HALF : bodies.SURFACE]
    if body[bodies.KIND] == bodies.SPHERE:
        level, distance = math.hypot(centre[0], centre[1]), math.hypot(*centre)
        if level <= half[0]:
            return ALL_ROUND
        bearing, across = math.atan2(centre[1], centre[0]), math.asin(half[0] / level)
        elevation, upward = math.atan2(-centre[2], level), math.asin(half[0] / distance)
        return bearing - across, bearing + across, elevation - upward, elevation + upward
    points = centre + (_BOX_EDGES * half) @ body[bodies.AXES : bodies.HALF].reshape(3, 3)
    if np.any(points[:, 0] <= 0.0):
        return ALL_ROUND
    bearings = np.arctan2(points[:, 1], points[:, 0])
    elevations = np.arctan2(-points[:, 2], np.hypot(points[:, 0], points[:, 1]))
    return float(bearings.min()), float(bearings.max()), float(elevations.min()), float(elevations.max())


def _box_edges() -> Array:
    """Return points along the edges of the cube [-1, 1]^3, where bearing and elevation of a box are extreme."""
    along = np.linspace(-1.0, 1.0, 17)
    return np.array(
        [np.roll([x, y, z], axis) for axis in range(3) for x in along for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
    )


_BOX_EDGES = _box_edges()
