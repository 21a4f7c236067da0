"""The mean echo of one object, by rays just wide and fine enough for it.

Rays meet the object at the centres of cells of bearing and elevation. A cell returns gamma S^2 R^2 over its solid angle
(eq. 5; R^2 turns solid angle into area) and spreads it, as a trapezoid, over the ranges that the slope towards its
neighbours spans, which is exact for a flat patch: few rays give a smooth profile. Cells are then mixed into the
beams by the horizontal pattern, side lobes included.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.sim_sonar.echo.bodies import FAR, Bodies, hit
from ods.sim_sonar.echo.mixing import mix, shares_of
from ods.sim_sonar.echo.ray_budget import RayFan
from ods.sim_sonar.echo.reflection import reflectivity
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import Grid, mean_two_way


class Occluders(NamedTuple):
    """What may hide an object."""

    rivals: Ints
    """Numbers of the bodies that may."""
    limit: Floats
    """(bearings, elevations) ranges at which the sea-bed does."""


class Bins(NamedTuple):
    """Range bins [start, end) of a row, about the range of an echo."""

    start: int
    end: int
    edge_m: float
    """Near edge of bin 0."""
    dr_m: float


@compiled
def add_object(image: Floats, bodies: Bodies, which: int, occluders: Occluders, rays: RayFan, grid: Grid) -> Floats:
    """Add the mean echo, m2, of body `which` to `image` (beams, samples) and return the ranges its rays meet it at.

    The ranges (bearings, elevations) are FAR where the object is not met first.
    """
    ranges, echo = _trace(bodies, which, occluders, rays)
    cells = np.zeros((len(grid.vertical), len(rays.bearing) - 1, grid.samples))
    first, last = _deposit(cells, ranges, echo, rays, grid)
    mix(image, cells, first, last, shares_of(rays.bearing, grid, math.inf))
    return ranges


@compiled
def _trace(bodies: Bodies, which: int, occluders: Occluders, rays: RayFan) -> tuple[Floats, Floats]:
    """Return range (FAR where not met first) and gamma R^2 of the ray through each cell, (bearings, elevations)."""
    body, limit, rivals = bodies[which], occluders.limit, occluders.rivals
    bearing, elevation = rays.bearing, rays.elevation
    ranges = np.full_like(limit, FAR)
    echo = np.zeros_like(limit)
    bearings, elevations = limit.shape[0], limit.shape[1]
    upward = 0.5 * (elevation[1:] + elevation[:-1])
    level, down = np.cos(upward), -np.sin(upward)
    for a in range(bearings):
        middle = 0.5 * (bearing[a] + bearing[a + 1])
        cos_bearing, sin_bearing = math.cos(middle), math.sin(middle)
        for e in range(elevations):
            x, y, z = level[e] * cos_bearing, level[e] * sin_bearing, down[e]
            distance, cosine = hit(body, x, y, z)
            if distance >= limit[a, e]:
                continue
            hidden = False
            for rival in rivals:
                hidden = hidden or hit(bodies[rival], x, y, z)[0] < distance
            if not hidden:
                ranges[a, e] = distance
                gamma = reflectivity(cosine, body["cd"], body["cs"], body["sigma_rad"])
                echo[a, e] = gamma * distance * distance
    return ranges, echo


@compiled
def _deposit(cells: Floats, ranges: Floats, echo: Floats, rays: RayFan, grid: Grid) -> tuple[int, int]:
    """Spread each cell's echo, m2 per radian of bearing, over range; return first and last+1 bin touched."""
    first, last = grid.samples, 0
    for e in range(ranges.shape[1]):
        low, high = math.sin(rays.elevation[e]), math.sin(rays.elevation[e + 1])
        for a in range(ranges.shape[0]):
            if echo[a, e] == 0.0:
                continue
            across, upward = _extent(ranges[:, e], a), _extent(ranges[a], e)
            wide, narrow = max(across, upward, 1e-6), max(min(across, upward), 1e-7)
            near = grid.edge_m - ranges[a, e]
            start = max(0, int((-0.5 * (wide + narrow) - near) / grid.dr_m))
            end = min(grid.samples, int((0.5 * (wide + narrow) - near) / grid.dr_m) + 1)
            first, last = min(first, start), max(last, end)
            for plane in range(len(cells)):
                power = echo[a, e] * (high - low) * mean_two_way(grid.vertical[plane], low, high)
                _spread(cells[plane, a], power, Bins(start, end, near, grid.dr_m), wide, narrow)
    return first, max(first, last)


@compiled
def _extent(ranges: Floats, k: int) -> float:
    """Return the range that cell `k` of a row spans, by its neighbours that are met."""
    total, count = 0.0, 0
    if k > 0 and ranges[k - 1] < FAR:
        total += abs(ranges[k] - ranges[k - 1])
        count += 1
    if k + 1 < len(ranges) and ranges[k + 1] < FAR:
        total += abs(ranges[k + 1] - ranges[k])
        count += 1
    return total / max(count, 1)


@compiled
def _spread(row: Floats, power: float, bins: Bins, wide: float, narrow: float) -> None:
    """Add `power` to `bins` of `row` as a trapezoid about 0: two boxes, wide and narrow, folded."""
    before = _trapezoid(bins.edge_m + bins.start * bins.dr_m, wide, narrow)
    for j in range(bins.start, bins.end):
        after = _trapezoid(bins.edge_m + (j + 1) * bins.dr_m, wide, narrow)
        row[j] += power * (after - before)
        before = after


@compiled
def _trapezoid(x: float, wide: float, narrow: float) -> float:
    """Return the share of the trapezoid below `x`."""
    foot, shoulder = 0.5 * (wide + narrow), 0.5 * (wide - narrow)
    if x <= -foot:
        return 0.0
    if x >= foot:
        return 1.0
    if x < -shoulder:
        return (x + foot) ** 2 / (2.0 * wide * narrow)
    if x <= shoulder:
        return 0.5 + x / wide
    return 1.0 - (foot - x) ** 2 / (2.0 * wide * narrow)
