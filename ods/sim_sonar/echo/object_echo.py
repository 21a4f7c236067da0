"""The mean echo of one object, by columns of bearing that just cover it.

At each bearing a plane is drawn in closed form (see flat_surface), a sphere or cylinder by rays through the centres of
cells of elevation that go from its lower to its upper end. A cell returns gamma S^2 R^2 over its solid angle (eq. 5;
R^2 turns solid angle into area) and spreads it, as a trapezoid, over the ranges that the slope towards its neighbours
spans, which is exact for a flat patch: few rays give a smooth profile. Columns are then mixed into the beams by the
horizontal pattern, side lobes included, as far as half a turn ahead goes.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.sim_sonar.echo.bodies import FAR, PLANE, Bodies, Body, hit
from ods.sim_sonar.echo.flat_surface import FlatSurface, flat_surface, surface_column
from ods.sim_sonar.echo.mixing import mix_column, shares_of
from ods.sim_sonar.echo.ray_budget import RayFan
from ods.sim_sonar.echo.reflection import reflectivity
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import Grid, mean_two_way

NEAR_WIDTHS = 3.0
"""Beam widths from a column within which beams hear it on its own; the others hear it with its neighbours."""
LEAST_SMEAR = 0.5
"""Bins under which a column's range counts as one."""


class Occluders(NamedTuple):
    """What may hide an object."""

    rivals: Ints
    """Numbers of the bodies that may."""
    limit: Floats
    """(bearings, elevations) ranges at which the sea-bed does."""


Column = tuple[RayFan, int]
"""One of a fan's columns, by its number."""


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
    bearing, beams = rays.bearing, len(grid.bearing_rad)
    rows, shares = np.zeros((len(grid.vertical), grid.samples)), shares_of(bearing, grid, math.inf)
    together, flat = np.zeros_like(rows), _surface_of(bodies[which], grid)
    a, reach = 0, NEAR_WIDTHS * grid.beam_width_rad
    while a < len(ranges):
        end = _neighbours(bearing, a, grid)
        low = np.searchsorted(grid.bearing_rad, bearing[a] - reach)
        high = np.searchsorted(grid.bearing_rad, bearing[end] + reach)
        begin, finish = grid.samples, 0
        for column in range(a, end):
            if bodies[which]["kind"] == PLANE:
                first, last = _plane_column(rows, flat, ranges, (rays, column), grid)
            else:
                first, last = _column(rows, ranges, echo, (rays, column), grid)
            mix_column(image, rows, (first, last), shares[:, column], (low, high))
            _gather(together, rows, (first, last), bearing[column + 1] - bearing[column])
            begin, finish = min(begin, first), max(finish, last)
        far = shares[:, a:end].sum(axis=1) / (bearing[end] - bearing[a])
        mix_column(image, together, (begin, finish), far, (0, low))
        mix_column(image, together, (begin, finish), far, (high, beams))
        together[:, begin:finish] = 0.0
        a = end
    return ranges


@compiled
def _neighbours(bearing: Floats, a: int, grid: Grid) -> int:
    """Return the end of the columns from `a` on that distant beams hear together; aside of all beams each is alone.

    Those of one beam width, counted from straight ahead: left and right are alike.
    """
    mine, end = int((bearing[a] + bearing[a + 1]) / (2.0 * grid.beam_width_rad)), a + 1
    while end < len(bearing) - 1 and int((bearing[end] + bearing[end + 1]) / (2.0 * grid.beam_width_rad)) == mine:
        if bearing[a] < grid.bearing_rad[0] or bearing[end + 1] > grid.bearing_rad[-1]:
            break
        end += 1
    return end


@compiled
def _gather(together: Floats, rows: Floats, bins: tuple[int, int], width: float) -> None:
    """Add `rows` times `width` to `together`, both (planes, samples), between two bins; then set them to 0."""
    for plane in range(len(rows)):
        for j in range(bins[0], bins[1]):
            together[plane, j] += width * rows[plane, j]
            rows[plane, j] = 0.0


@compiled
def _surface_of(body: Body, grid: Grid) -> FlatSurface:
    """Return the plane in which a body lies that is one."""
    normal = body["axes"][2].copy()
    height = np.sum(normal * body["centre"])
    if height < 0.0:
        normal, height = -normal, -height
    if body["kind"] != PLANE:
        return FlatSurface(normal, height, np.empty(0), np.empty(0))
    return flat_surface(grid, normal, height, (body["cd"], body["cs"], body["sigma_rad"]))


@compiled
def _plane_column(rows: Floats, flat: FlatSurface, ranges: Floats, column: Column, grid: Grid) -> tuple[int, int]:
    """Add a plane's echo at one bearing, m2 per radian, to `rows` (planes, samples), which are zero.

    All runs of its visible cells are drawn at the middle of the column and smeared over the range that it spans.
    """
    rays, a = column
    middle, elevation, cells = 0.5 * (rays.bearing[a] + rays.bearing[a + 1]), rays.elevation[a], ranges.shape[1]
    first, last, start = grid.samples, 0, -1
    for e in range(cells + 1):
        seen = e < cells and ranges[a, e] < FAR
        if seen and start < 0:
            start = e
        elif not seen and start >= 0:
            begin, end = surface_column(flat, grid, middle, (elevation[start], elevation[e]), rows)
            first, last, start = min(first, begin), max(last, end), -1
    width = _extent(ranges[:, cells // 2], a) / grid.dr_m
    if first >= last or width < LEAST_SMEAR:
        return first, last
    reach = int(0.5 * width) + 2
    first, last = max(first - reach, 0), min(last + reach, grid.samples)
    for plane in range(len(rows)):
        _smear(rows[plane, first:last], width)
    return first, last


@compiled
def _smear(row: Floats, width: float) -> None:
    """Spread what is in each bin evenly over `width` bins about its middle."""
    bins = len(row)
    # the running integral, over bins, of what lies below the middle of each
    total, below = np.zeros(bins + 1), 0.0
    for j in range(bins):
        below += row[j]
        total[j + 1] = total[j] + below
    for j in range(bins):
        row[j] = 0.0
    for side in (-0.5, 0.5):
        before = _sum_at(total, below, side * width)
        for j in range(bins):
            after = _sum_at(total, below, j + 1.0 + side * width)
            row[j] += math.copysign(1.0, side) * (after - before) / width
            before = after


@compiled
def _sum_at(total: Floats, below: float, place: float) -> float:
    """Return `total`, whose nodes are the middles of bins and the first of them that of bin 0, at `place` in bins."""
    where, last = place - 0.5, len(total) - 1
    if where <= 0.0:
        return 0.0
    if where >= last:
        return float(total[last] + below * (where - last))
    node = int(where)
    return float(total[node] + (where - node) * (total[node + 1] - total[node]))


@compiled
def _trace(bodies: Bodies, which: int, occluders: Occluders, rays: RayFan) -> tuple[Floats, Floats]:
    """Return range (FAR where not met first) and gamma R^2 of the ray through each cell, (bearings, elevations)."""
    body, limit, rivals = bodies[which], occluders.limit, occluders.rivals
    bearing, elevation = rays.bearing, rays.elevation
    ranges = np.full_like(limit, FAR)
    echo = np.zeros_like(limit)
    bearings, elevations = limit.shape[0], limit.shape[1]
    for a in range(bearings):
        upward = 0.5 * (elevation[a, 1:] + elevation[a, :-1])
        level, down = np.cos(upward), -np.sin(upward)
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
                if body["kind"] == PLANE:
                    continue
                gamma = reflectivity(cosine, body["cd"], body["cs"], body["sigma_rad"])
                echo[a, e] = gamma * distance * distance
    return ranges, echo


@compiled
def _column(rows: Floats, ranges: Floats, echo: Floats, column: Column, grid: Grid) -> tuple[int, int]:
    """Spread the echo of one bearing's cells, m2 per radian of bearing, over `rows` (planes, samples).

    Returns first and last+1 bin touched.
    """
    rays, a = column
    first, last = grid.samples, 0
    sines = np.sin(rays.elevation[a])
    for e in range(ranges.shape[1]):
        if echo[a, e] == 0.0:
            continue
        (begin, across), (below, upward) = _span(ranges[:, e], a, grid.dr_m), _span(ranges[a], e, grid.dr_m)
        wide, narrow = max(across, upward, 1e-6), max(min(across, upward), 1e-7)
        near = grid.edge_m - (ranges[a, e] + begin + below + 0.5 * (across + upward))
        start = max(0, int((-0.5 * (wide + narrow) - near) / grid.dr_m))
        end = min(grid.samples, int((0.5 * (wide + narrow) - near) / grid.dr_m) + 1)
        first, last = min(first, start), max(last, end)
        for plane in range(len(rows)):
            power = echo[a, e] * (sines[e + 1] - sines[e]) * mean_two_way(grid.vertical[plane], sines[e], sines[e + 1])
            _spread(rows[plane], power, Bins(start, end, near, grid.dr_m), wide, narrow)
    return first, last


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
def _span(ranges: Floats, k: int, slack: float) -> tuple[float, float]:
    """Return by how much the range that cell `k` of a row spans begins beyond its middle's, and how long it is.

    It goes no farther than `slack` beyond its neighbours' ranges: at the rim of a cylinder's end, where the surface is
    bent, the end's slope gave an echo nearer than the nearest point of the body.
    """
    half = 0.5 * _extent(ranges, k)
    begin, end = -half, half
    if 0 < k < len(ranges) - 1 and ranges[k - 1] < FAR and ranges[k + 1] < FAR:
        before, after = ranges[k - 1] - ranges[k], ranges[k + 1] - ranges[k]
        begin, end = max(begin, min(before, after, 0.0) - slack), min(end, max(before, after, 0.0) + slack)
    return begin, end - begin


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
