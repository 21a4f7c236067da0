"""A flat sea-bed's echo: columns in closed form, and what lies between them."""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.bodies import FAR
from ods.sim_sonar.echo.flat_surface import LEVEL, FlatSurface, surface_column
from ods.sim_sonar.echo.mixing import mix, pattern_width, shares_of
from ods.sim_sonar.echo.ray_budget import RayFan
from ods.sim_sonar.echo.shadow import Shades
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import Grid

ALL_AHEAD = (-0.5 * math.pi, 0.5 * math.pi)
"""Elevations of a half plane."""


@compiled
def bed_columns(bed: FlatSurface, grid: Grid, lean: float) -> Floats:
    """Return the echo, m2 per radian of bearing, at bearings evenly from the first to the last beam.

    (planes, bearings, samples); one bearing when the bed is level. From one to the next the elevation of the sea-bed
    changes by at most `lean` radians, so that what lies between is linear.
    """
    tilt = math.hypot(bed.down[0], bed.down[1])
    span = grid.bearing_rad[-1] - grid.bearing_rad[0]
    parts = min(math.ceil(tilt * span / lean), 4 * len(grid.bearing_rad)) if tilt > LEVEL else 0
    out = np.zeros((len(grid.vertical), parts + 1, grid.samples))
    for k in range(parts + 1):
        surface_column(bed, grid, grid.bearing_rad[0] + span * k / max(parts, 1), ALL_AHEAD, out[:, k])
    return out


@compiled
def _blend(columns: Floats, bearing_rad: float, grid: Grid, first: int, out: Floats) -> None:
    """Set `out`, bins from `first` on, to the echo at one bearing between those of one plane's `columns`."""
    parts = len(columns) - 1
    span = max(grid.bearing_rad[-1] - grid.bearing_rad[0], 1e-9)
    place = min(max((bearing_rad - grid.bearing_rad[0]) / span, 0.0), 1.0) * parts
    k = min(int(place), max(parts - 1, 0))
    share = place - k
    last = first + len(out)
    low, high = columns[k, first:last], columns[min(k + 1, parts), first:last]
    for j in range(len(out)):
        out[j] = low[j] + share * (high[j] - low[j])


@compiled
def add_bed(image: Floats, columns: Floats, grid: Grid) -> None:
    """Add the sea-bed's mean echo, m2, to `image` (beams, samples); it varies little across a beam."""
    beams = len(grid.bearing_rad)
    width = pattern_width(grid)
    column = np.empty(grid.samples)
    for plane in range(len(columns)):
        for beam in range(beams):
            if beam == 0 or columns.shape[1] > 1:
                _blend(columns[plane], grid.bearing_rad[beam], grid, 0, column)
            row = image[plane * beams + beam]
            for j in range(grid.samples):
                row[j] += width * column[j]


@compiled
def hide_bed(image: Floats, bed: FlatSurface, columns: Floats, grid: Grid, shades: Shades, reach: float) -> None:
    """Take out of `image` (beams, samples) what `shades` hide of the sea-bed."""
    border = np.empty(2)
    column = np.empty((len(columns), 1, grid.samples))
    for k in range(len(shades)):
        shade = shades[k]
        border[0], border[1] = shade["west"], shade["east"]
        middle = 0.5 * (shade["west"] + shade["east"])
        near, far = _meet(bed, middle, shade["low"]), _meet(bed, middle, shade["high"])
        begin = max((near - grid.edge_m) / grid.dr_m, 0.0)
        finish = min((far - grid.edge_m) / grid.dr_m, float(grid.samples))
        if begin >= finish:
            continue
        first, last = int(begin), min(int(finish) + 1, grid.samples)
        for plane in range(len(columns)):
            _blend(columns[plane], middle, grid, first, column[plane, 0, first:last])
            column[plane, 0, first] *= min(first + 1.0, finish) - begin
            if last - 1 > first:
                column[plane, 0, last - 1] *= max(0.0, finish - (last - 1))
        mix(image, column, first, last, -shares_of(border, grid, reach))


@compiled
def flat_ranges(bed: FlatSurface, rays: RayFan) -> Floats:
    """Return the (bearings, elevations) ranges, FAR where there is none, at which rays meet the sea-bed."""
    bearing, elevation = rays.bearing, rays.elevation
    sines = np.sin(0.5 * (elevation[:, 1:] + elevation[:, :-1]))
    columns, cells = len(bearing) - 1, elevation.shape[1] - 1
    out = np.empty((columns, cells))
    for a in range(columns):
        for e in range(cells):
            out[a, e] = _meet(bed, 0.5 * (bearing[a] + bearing[a + 1]), sines[a, e])
    return out


@compiled
def _meet(bed: FlatSurface, bearing_rad: float, sine: float) -> float:
    """Return the range, FAR where there is none, of the sea-bed at a bearing and the sine of an elevation."""
    level = math.sqrt(max(0.0, 1.0 - sine * sine))
    along = bed.down[0] * math.cos(bearing_rad) + bed.down[1] * math.sin(bearing_rad)
    sinking = along * level - bed.down[2] * sine
    return float(bed.height_m / sinking) if sinking * FAR > bed.height_m else FAR
