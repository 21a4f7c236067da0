"""The echo of a plane, eq. 5 integrated over each range bin in closed form.

At a bearing, the points of a plane at slant range R lie at the elevation b with (n . u(b)) R = h: n is the direction
straight to the plane in the sonar's frame, h its distance. A bin's solid angle per radian of bearing is the difference
of sin(b) between its edges, so that not even the singular start of the echo, straight ahead of it, needs a fine grid.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.reflection import reflectivity
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import SUM_NODES, Grid

LEVEL = 1e-9
"""Tilt, in radians, that is none."""


class FlatSurface(NamedTuple):
    """A plane as the sonar sees it."""

    down: Floats
    """(3,) unit vector from the sonar straight to the plane, in the sonar's frame: down, for a level sea-surface."""
    height_m: float
    """Distance of the plane."""
    weight: Floats
    """(samples,) gamma R^2, m2: eq. 3 at each sample's incidence angle, whose cosine is h / R."""
    nearness: Floats
    """(samples + 1,) 1 / R at the borders of the samples, 1/m."""


class FlatColumn(NamedTuple):
    """The half plane of one bearing: the foot of the perpendicular from the sonar, and its elevation."""

    nearest_m: float
    cosine: float
    sine: float


@compiled
def flat_surface(grid: Grid, down: Floats, height_m: float, reflects: tuple[float, float, float]) -> FlatSurface:
    """Return a plane `height_m` away in the direction `down` (3,), sonar's frame; `reflects`: cd, cs, sigma in rad."""
    weight, nearness = np.zeros(grid.samples), np.empty(grid.samples + 1)
    cd, cs, sigma_rad = reflects
    for j in range(grid.samples):
        distance = max(grid.edge_m + (j + 0.5) * grid.dr_m, 1e-9)
        weight[j] = reflectivity(min(1.0, height_m / distance), cd, cs, sigma_rad) * distance * distance
    for j in range(grid.samples + 1):
        nearness[j] = 1.0 / max(grid.edge_m + j * grid.dr_m, 1e-9)
    return FlatSurface(down, height_m, weight, nearness)


@compiled
def surface_column(
    surface: FlatSurface, grid: Grid, bearing_rad: float, span: tuple[float, float], out: Floats
) -> tuple[int, int]:
    """Add the plane's echo at one bearing, m2 per radian of bearing, to `out` (planes, samples).

    `span`: least and greatest elevation, rad. Returns first and last+1 bin touched.
    """
    along = surface.down[0] * math.cos(bearing_rad) + surface.down[1] * math.sin(bearing_rad)
    steep = math.hypot(along, surface.down[2])
    if steep < LEVEL:
        return grid.samples, 0
    low, high = span
    axis = math.atan2(-surface.down[2], along)
    column = FlatColumn(surface.height_m / steep, along / steep, -surface.down[2] / steep)
    right = 0.5 * math.pi
    first, last = _branch(surface, grid, column, (max(low - axis, 0.0), min(high - axis, right), 1.0), out)
    begin, end = _branch(surface, grid, column, (max(axis - high, 0.0), min(axis - low, right), -1.0), out)
    return min(first, begin), max(last, end)


@compiled
def _branch(
    surface: FlatSurface, grid: Grid, column: FlatColumn, turn: tuple[float, float, float], out: Floats
) -> tuple[int, int]:
    """One side of the perpendicular's foot: angles to it from the first to the second of `turn`, up (1) or down (-1).

    The cosine of the angle is nearest / R.
    """
    nearest, cosine, sine = column
    near, far, side = turn
    if near >= far:
        return grid.samples, 0
    high, low = math.cos(near), max(math.cos(far), 1e-9)
    first = max(0, int((nearest / high - grid.edge_m) / grid.dr_m))
    last = int(min((nearest / low - grid.edge_m) / grid.dr_m + 1.0, float(grid.samples)))
    if first >= last:
        return grid.samples, 0
    place = np.empty(last - first + 1)
    scale, aside = 0.5 * (SUM_NODES - 1), side * cosine
    for k in range(len(place)):
        c = min(max(nearest * surface.nearness[first + k], low), high)
        place[k] = min(max((sine * c + aside * math.sqrt(1.0 - c * c) + 1.0) * scale, 0.0), SUM_NODES - 1.001)
    for plane in range(len(out)):
        _look_up(grid.vertical_sum[plane], place, surface.weight[first:last], out[plane, first:last])
    return first, last


@compiled
def _look_up(table: Floats, place: Floats, weight: Floats, out: Floats) -> None:
    """Add `weight` (bins,) times the change of `table`, the vertical pattern's sum, between `place` (bins + 1,)."""
    heard = np.empty(len(place))
    for k in range(len(place)):
        node = np.uint32(np.int32(place[k]))
        heard[k] = table[node] + (place[k] - np.int32(place[k])) * (table[node + np.uint32(1)] - table[node])
    for k in range(len(out)):
        out[k] += weight[k] * abs(heard[k + 1] - heard[k])
