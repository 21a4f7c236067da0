"""The mean echo of one object: a fan of rays just wide and fine enough for it.

Rays meet the object at the centres of cells of bearing and elevation. A cell returns gamma S^2 R^2 over its solid angle
(eq. 5; R^2 turns solid angle into area) and spreads it, as a trapezoid, over the ranges that the slope towards its
neighbours spans, which is exact for a flat patch: a coarse fan gives a smooth profile. Cells are then mixed into the
beams by the horizontal pattern, side lobes included.
"""

import math

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.sim_sonar.echo.bodies import FAR, SURFACE, hit
from ods.sim_sonar.echo.mixing import mix, shares_of
from ods.sim_sonar.echo.reflection import reflectivity
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import Grid, two_way


@compiled
def add_object(
    image: Floats,
    all_bodies: Floats,
    which: int,
    rivals: Ints,
    bearing: Floats,
    elevation: Floats,
    limit: Floats,
    grid: Grid,
) -> Floats:
    """Add the mean echo, m2, of body `which` to `image` (beams, samples) and return the ranges its rays meet it at.

    `bearing` and `elevation` are the borders of the fan's cells, `rivals` the bodies that may hide this one, `limit`
    (bearings, elevations) the ranges at which the sea-bed does. The ranges, of the same shape, are FAR where the object
    is not met first.
    """
    ranges, echo = _trace(all_bodies, which, rivals, bearing, elevation, limit)
    cells = np.zeros((len(grid.vertical), len(bearing) - 1, grid.samples))
    first, last = _deposit(cells, ranges, echo, bearing, elevation, grid)
    mix(image, cells, first, last, shares_of(bearing, grid, math.inf))
    return ranges


@compiled
def _trace(
    all_bodies: Floats, which: int, rivals: Ints, bearing: Floats, elevation: Floats, limit: Floats
) -> tuple[Floats, Floats]:
    """Return range (FAR where not met first) and gamma R^2 of the ray through each cell, (bearings, elevations)."""
    body = all_bodies[which]
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
                hidden = hidden or hit(all_bodies[rival], x, y, z)[0] < distance
            if not hidden:
                ranges[a, e] = distance
                gamma = reflectivity(cosine, body[SURFACE], body[SURFACE + 1], body[SURFACE + 2])
                echo[a, e] = gamma * distance * distance
    return ranges, echo


@compiled
def _deposit(
    cells: Floats, ranges: Floats, echo: Floats, bearing: Floats, elevation: Floats, grid: Grid
) -> tuple[int, int]:
    """Spread each cell's echo, m2 per radian of bearing, over range; return first and last+1 bin touched."""
    first, last = grid.samples, 0
    for e in range(ranges.shape[1]):
        low, high = math.sin(elevation[e]), math.sin(elevation[e + 1])
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
                power = echo[a, e] * (high - low) * two_way(grid.vertical[plane], low, high)
                _spread(cells[plane, a], power, start, end, near, grid.dr_m, wide, narrow)
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
def _spread(
    row: Floats, power: float, start: int, end: int, edge: float, step: float, wide: float, narrow: float
) -> None:
    """Add `power` to bins [start, end) of `row` as a trapezoid about 0: two boxes, wide and narrow, folded."""
    before = _trapezoid(edge + start * step, wide, narrow)
    for j in range(start, end):
        after = _trapezoid(edge + (j + 1) * step, wide, narrow)
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
