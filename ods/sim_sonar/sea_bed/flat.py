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
from ods.sim_sonar.sonar.grid import Grid, mean_two_way

LEVEL = 1e-9
"""Tilt, in radians, under which every bearing sees the same profile."""


class FlatBed(NamedTuple):
    """A flat sea-bed as the sonar sees it."""

    down: Floats
    """(3,) unit vector straight down, in the sonar's frame."""
    height_m: float
    """Sonar above sea-bed; 0 or less: there is none."""
    gamma: Floats
    """(samples,) eq. 3 at each sample's incidence angle, whose cosine is h / R."""


class FlatColumn(NamedTuple):
    """The half plane of one bearing: the foot of the perpendicular on the sea-bed, and how that is tilted."""

    nearest_m: float
    cos_tilt: float
    sin_tilt: float


@compiled
def reflectivity_profile(grid: Grid, height_m: float, cd: float, cs: float, sigma_rad: float) -> Floats:
    """Return eq. 3 at the centre of each range bin for a sonar `height_m` above a flat sea-bed."""
    gamma = np.zeros(grid.samples)
    for j in range(grid.samples):
        distance = max(grid.edge_m + (j + 0.5) * grid.dr_m, 1e-9)
        gamma[j] = reflectivity(min(1.0, height_m / distance), cd, cs, sigma_rad)
    return gamma


@compiled
def bed_column(bed: FlatBed, grid: Grid, bearing_rad: float, out: Floats) -> None:
    """Add the sea-bed's echo at one bearing, m2 per radian of bearing, to `out` (planes, samples)."""
    along = bed.down[0] * math.cos(bearing_rad) + bed.down[1] * math.sin(bearing_rad)
    steep = math.hypot(along, bed.down[2])
    ahead = FlatColumn(bed.height_m / steep, along / steep, bed.down[2] / steep)
    # ahead of the foot of the perpendicular, and behind it as far as that is still in this half plane
    if along < 0.0:
        _branch(bed, grid, ahead, 0.0, ahead.sin_tilt, out)
    else:
        _branch(bed, grid, ahead, 0.0, 1.0, out)
        if along > LEVEL:
            behind = FlatColumn(ahead.nearest_m, -ahead.cos_tilt, ahead.sin_tilt)
            _branch(bed, grid, behind, ahead.sin_tilt, 1.0, out)


@compiled
def _branch(bed: FlatBed, grid: Grid, column: FlatColumn, low: float, high: float, out: Floats) -> None:
    """One side of the perpendicular's foot; the cosine of the angle to it, nearest / R, runs from `high` to `low`."""
    nearest, cos_tilt, sin_tilt = column
    first = max(0, int((nearest / high - grid.edge_m) / grid.dr_m))
    before = high * sin_tilt - math.sqrt(1.0 - high * high) * cos_tilt
    for j in range(first, grid.samples):
        cosine = min(max(nearest / (grid.edge_m + (j + 1) * grid.dr_m), low), high)
        after = cosine * sin_tilt - math.sqrt(1.0 - cosine * cosine) * cos_tilt
        distance = max(grid.edge_m + (j + 0.5) * grid.dr_m, nearest)
        area = bed.gamma[j] * distance * distance * abs(before - after)
        for plane in range(len(out)):
            out[plane, j] += area * mean_two_way(grid.vertical[plane], -before, -after)
        before = after


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
        bed_column(bed, grid, grid.bearing_rad[0] + span * k / max(parts, 1), out[:, k])
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
