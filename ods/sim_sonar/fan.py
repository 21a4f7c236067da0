"""The mean echo of one object: a fan of rays just wide and fine enough for it.

Rays meet the object at the centres of cells of bearing and elevation. A cell returns gamma S^2 R^2 over its solid angle
(eq. 5; R^2 turns solid angle into area) and spreads it, as a trapezoid, over the ranges that the slope towards its
neighbours spans, which is exact for a flat patch: a coarse fan gives a smooth profile. Cells are then mixed into the
beams by the horizontal pattern, side lobes included. What the rays would have met behind the object is taken out of the
sea-bed's echo: the shadow.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ods.sim_sonar.bodies import FAR, SURFACE, hit
from ods.sim_sonar.grid import Grid, beam_share, two_way
from ods.sim_sonar.jit import compiled
from ods.sim_sonar.reflection import reflectivity
from ods.sim_sonar.sea_bed import FlatBed, bed_column, bed_range

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

FAINT_SHADOW = 1e-3
"""Share of a beam's pattern below which a shadow is left out of a beam."""


@compiled
def add_object(
    image: Array,
    all_bodies: Array,
    which: int,
    rivals: Indices,
    bearing: Array,
    elevation: Array,
    grid: Grid,
    bed: FlatBed,
    shadow: bool,
) -> None:
    """Add the mean echo, m2, of body `which` to `image` (beams, samples); `shadow`: take its shadow out of the bed's.

    `bearing` and `elevation` are the borders of the fan's cells, `rivals` the bodies that may hide this one. What lies
    under the sea-bed is not seen.
    """
    ranges, echo = _trace(all_bodies, which, rivals, bearing, elevation, bed)
    cells = np.zeros((len(grid.vertical), len(bearing) - 1, grid.samples))
    first, last = _deposit(cells, ranges, echo, bearing, elevation, grid)
    _mix(image, cells, first, last, bearing, grid, 0.0)
    if shadow and bed.height_m > 0.0:
        cells[:, :, first:last] = 0.0
        first, last = _hide(cells, ranges, bearing, elevation, grid, bed)
        _mix(image, cells, first, last, bearing, grid, FAINT_SHADOW)


@compiled
def _trace(
    all_bodies: Array, which: int, rivals: Indices, bearing: Array, elevation: Array, bed: FlatBed
) -> tuple[Array, Array]:
    """Return range (FAR where not met first) and gamma R^2 of the ray through each cell, (bearings, elevations)."""
    body = all_bodies[which]
    ranges = np.full((len(bearing) - 1, len(elevation) - 1), FAR)
    echo = np.zeros(ranges.shape)
    for a in range(ranges.shape[0]):
        middle = 0.5 * (bearing[a] + bearing[a + 1])
        cos_bearing, sin_bearing = math.cos(middle), math.sin(middle)
        for e in range(ranges.shape[1]):
            upward = 0.5 * (elevation[e] + elevation[e + 1])
            level = math.cos(upward)
            x, y, z = level * cos_bearing, level * sin_bearing, -math.sin(upward)
            distance, cosine = hit(body, x, y, z)
            if distance >= bed_range(bed, x, y, z, FAR):
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
def _deposit(cells: Array, ranges: Array, echo: Array, bearing: Array, elevation: Array, grid: Grid) -> tuple[int, int]:
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
def _extent(ranges: Array, k: int) -> float:
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
    row: Array, power: float, start: int, end: int, edge: float, step: float, wide: float, narrow: float
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


@compiled
def _hide(cells: Array, ranges: Array, bearing: Array, elevation: Array, grid: Grid, bed: FlatBed) -> tuple[int, int]:
    """Put the sea-bed's echo that the object hides, negative, into `cells`; return first and last+1 bin touched."""
    first, last = grid.samples, 0
    column = np.zeros((len(cells), grid.samples))
    hidden = np.zeros(grid.samples)
    for a in range(len(bearing) - 1):
        hidden[:] = 0.0
        middle = 0.5 * (bearing[a] + bearing[a + 1])
        start, end = _shade(hidden, ranges, a, middle, elevation, grid, bed)
        if start >= end:
            continue
        first, last = min(first, start), max(last, end)
        column[:] = 0.0
        bed_column(bed, grid, middle, column)
        for plane in range(len(cells)):
            for j in range(start, end):
                cells[plane, a, j] = -min(hidden[j], 1.0) * column[plane, j]
    return first, max(first, last)


@compiled
def _shade(
    hidden: Array, ranges: Array, a: int, middle: float, elevation: Array, grid: Grid, bed: FlatBed
) -> tuple[int, int]:
    """Set the share of each bin of the sea-bed that one column of cells hides; return first and last+1 bin."""
    first, last = grid.samples, 0
    cosine, sine = math.cos(middle), math.sin(middle)
    for e in range(len(elevation) - 1):
        low, high = elevation[e], elevation[e + 1]
        near = bed_range(bed, math.cos(low) * cosine, math.cos(low) * sine, -math.sin(low), FAR)
        if ranges[a, e] >= FAR or near >= FAR:
            continue
        far = bed_range(bed, math.cos(high) * cosine, math.cos(high) * sine, -math.sin(high), FAR)
        begin = (near - grid.edge_m) / grid.dr_m
        finish = min((far - grid.edge_m) / grid.dr_m, float(grid.samples))
        start, end = max(0, int(begin)), min(grid.samples, int(finish) + 1)
        for j in range(start, end):
            hidden[j] += max(0.0, min(finish, j + 1.0) - max(begin, float(j)))
        first, last = min(first, start), max(last, end)
    return first, last


@compiled
def _mix(image: Array, cells: Array, first: int, last: int, bearing: Array, grid: Grid, faint: float) -> None:
    """Add columns of cells to the beams that hear them; beams with a share of `faint` or less of one do not."""
    beams = len(grid.bearing_rad)
    for beam in range(beams):
        for a in range(len(bearing) - 1):
            begin = (bearing[a] - grid.bearing_rad[beam]) / grid.beam_width_rad
            finish = (bearing[a + 1] - grid.bearing_rad[beam]) / grid.beam_width_rad
            share = beam_share(grid.horizontal, begin, finish)
            if share <= faint * (finish - begin):
                continue
            for plane in range(len(cells)):
                target = image[plane * beams + beam, first:last]
                source = cells[plane, a, first:last]
                for j in range(last - first):
                    target[j] += share * grid.beam_width_rad * source[j]
