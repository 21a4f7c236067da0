"""A flat sea-bed's echo, eq. 5 integrated over each range bin in closed form but for the vertical pattern.

At a bearing, the points of the sea-bed at slant range R lie at the elevation b with (n . u(b)) R = h: n is straight
down in the sonar's frame, h the height above the sea-bed. A bin's solid angle per radian of bearing is the difference
of sin(b) between its edges, so that not even the singular start of the echo, straight below, needs a fine grid.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.bodies import FAR
from ods.sim_sonar.echo.mixing import mix, pattern_width, shares_of
from ods.sim_sonar.echo.ray_budget import RayFan
from ods.sim_sonar.echo.reflection import reflectivity
from ods.sim_sonar.echo.shadow import Shades
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import SUM_NODES, Grid

ALL_AHEAD = (-0.5 * math.pi, 0.5 * math.pi)
"""Elevations of a half plane."""
LEVEL = 1e-9
"""Tilt, in radians, under which every bearing sees the same profile."""


class FlatBed(NamedTuple):
    """A plane as the sonar sees it."""

    down: Floats
    """(3,) unit vector from the sonar straight to the plane, in the sonar's frame: down, for a level sea-bed."""
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
def flat_bed(grid: Grid, down: Floats, height_m: float, surface: tuple[float, float, float]) -> FlatBed:
    """Return a plane `height_m` away in the direction `down` (3,), sonar's frame; `surface`: cd, cs, sigma in rad."""
    weight, nearness = np.zeros(grid.samples), np.empty(grid.samples + 1)
    cd, cs, sigma_rad = surface
    for j in range(grid.samples):
        distance = max(grid.edge_m + (j + 0.5) * grid.dr_m, 1e-9)
        weight[j] = reflectivity(min(1.0, height_m / distance), cd, cs, sigma_rad) * distance * distance
    for j in range(grid.samples + 1):
        nearness[j] = 1.0 / max(grid.edge_m + j * grid.dr_m, 1e-9)
    return FlatBed(down, height_m, weight, nearness)


@compiled
def bed_column(bed: FlatBed, grid: Grid, bearing_rad: float, span: tuple[float, float], out: Floats) -> tuple[int, int]:
    """Add the plane's echo at one bearing, m2 per radian of bearing, to `out` (planes, samples).

    `span`: least and greatest elevation, rad. Returns first and last+1 bin touched.
    """
    along = bed.down[0] * math.cos(bearing_rad) + bed.down[1] * math.sin(bearing_rad)
    steep = math.hypot(along, bed.down[2])
    if steep < LEVEL:
        return grid.samples, 0
    low, high = span
    axis = math.atan2(-bed.down[2], along)
    column = FlatColumn(bed.height_m / steep, along / steep, -bed.down[2] / steep)
    right = 0.5 * math.pi
    first, last = _branch(bed, grid, column, (max(low - axis, 0.0), min(high - axis, right), 1.0), out)
    begin, end = _branch(bed, grid, column, (max(axis - high, 0.0), min(axis - low, right), -1.0), out)
    return min(first, begin), max(last, end)


@compiled
def _branch(
    bed: FlatBed, grid: Grid, column: FlatColumn, turn: tuple[float, float, float], out: Floats
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
        c = min(max(nearest * bed.nearness[first + k], low), high)
        place[k] = min(max((sine * c + aside * math.sqrt(1.0 - c * c) + 1.0) * scale, 0.0), SUM_NODES - 1.001)
    for plane in range(len(out)):
        _look_up(grid.vertical_sum[plane], place, bed.weight[first:last], out[plane, first:last])
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


@compiled
def bed_columns(bed: FlatBed, grid: Grid, lean: float) -> Floats:
    """Return the echo, m2 per radian of bearing, at bearings evenly from the first to the last beam.

    (planes, bearings, samples); one bearing when the bed is level. From one to the next the elevation of the sea-bed
    changes by at most `lean` radians, so that what lies between is linear.
    """
    tilt = math.hypot(bed.down[0], bed.down[1])
    span = grid.bearing_rad[-1] - grid.bearing_rad[0]
    parts = min(math.ceil(tilt * span / lean), 4 * len(grid.bearing_rad)) if tilt > LEVEL else 0
    out = np.zeros((len(grid.vertical), parts + 1, grid.samples))
    for k in range(parts + 1):
        bed_column(bed, grid, grid.bearing_rad[0] + span * k / max(parts, 1), ALL_AHEAD, out[:, k])
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
def hide_bed(image: Floats, bed: FlatBed, columns: Floats, grid: Grid, shades: Shades, reach: float) -> None:
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
def flat_ranges(bed: FlatBed, rays: RayFan) -> Floats:
    """Return the (bearings, elevations) ranges, FAR where there is none, at which rays meet the sea-bed."""
    bearing, elevation = rays.bearing, rays.elevation
    sines = np.sin(0.5 * (elevation[1:] + elevation[:-1]))
    out = np.empty((len(bearing) - 1, len(sines)))
    for a in range(out.shape[0]):
        for e in range(out.shape[1]):
            out[a, e] = _meet(bed, 0.5 * (bearing[a] + bearing[a + 1]), sines[e])
    return out


@compiled
def _meet(bed: FlatBed, bearing_rad: float, sine: float) -> float:
    """Return the range, FAR where there is none, of the sea-bed at a bearing and the sine of an elevation."""
    level = math.sqrt(max(0.0, 1.0 - sine * sine))
    along = bed.down[0] * math.cos(bearing_rad) + bed.down[1] * math.sin(bearing_rad)
    sinking = along * level - bed.down[2] * sine
    return float(bed.height_m / sinking) if sinking * FAR > bed.height_m else FAR
