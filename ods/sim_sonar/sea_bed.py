"""A flat sea-bed's echo, eq. 5 integrated over each range bin in closed form but for the vertical pattern.

At a bearing, the points of the sea-bed at slant range R lie at the elevation b with (n . u(b)) R = h: n is straight
down in the sonar's frame, h the height above the sea-bed. A bin's solid angle per radian of bearing is the difference
of sin(b) between its edges, so that not even the singular start of the echo, straight below, needs a fine grid.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.sim_sonar.grid import Grid, beam_share, two_way
from ods.sim_sonar.jit import compiled
from ods.sim_sonar.reflection import reflectivity

Array = NDArray[np.float64]

LEVEL = 1e-9
"""Tilt, in radians, under which every bearing sees the same profile."""


class FlatBed(NamedTuple):
    """A flat sea-bed as the sonar sees it."""

    down: Array
    """(3,) unit vector straight down, in the sonar's frame."""
    height_m: float
    """Sonar above sea-bed; 0 or less: there is none."""
    gamma: Array
    """(samples,) eq. 3 at each sample's incidence angle, whose cosine is h / R."""


@compiled
def reflectivity_profile(grid: Grid, height_m: float, cd: float, cs: float, sigma_rad: float) -> Array:
    """Return eq. 3 at the centre of each range bin for a sonar `height_m` above a flat sea-bed."""
    gamma = np.zeros(grid.samples)
    for j in range(grid.samples):
        distance = max(grid.edge_m + (j + 0.5) * grid.dr_m, 1e-9)
        gamma[j] = reflectivity(min(1.0, height_m / distance), cd, cs, sigma_rad)
    return gamma


@compiled
def bed_column(bed: FlatBed, grid: Grid, bearing_rad: float, out: Array) -> None:
    """Add the sea-bed's echo at one bearing, m2 per radian of bearing, to `out` (planes, samples)."""
    along = bed.down[0] * math.cos(bearing_rad) + bed.down[1] * math.sin(bearing_rad)
    steep = math.hypot(along, bed.down[2])
    cos_tilt, sin_tilt = along / steep, bed.down[2] / steep
    nearest = bed.height_m / steep
    # ahead of the foot of the perpendicular, and behind it as far as that is still in this half plane
    if along < 0.0:
        _branch(bed, grid, nearest, 0.0, sin_tilt, cos_tilt, sin_tilt, out)
    else:
        _branch(bed, grid, nearest, 0.0, 1.0, cos_tilt, sin_tilt, out)
        if along > LEVEL:
            _branch(bed, grid, nearest, sin_tilt, 1.0, -cos_tilt, sin_tilt, out)


@compiled
def _branch(
    bed: FlatBed, grid: Grid, nearest: float, low: float, high: float, cos_tilt: float, sin_tilt: float, out: Array
) -> None:
    """One side of the perpendicular's foot; the cosine of the angle to it, nearest / R, runs from `high` to `low`."""
    first = max(0, int((nearest / high - grid.edge_m) / grid.dr_m))
    before = high * sin_tilt - math.sqrt(1.0 - high * high) * cos_tilt
    for j in range(first, grid.samples):
        cosine = min(max(nearest / (grid.edge_m + (j + 1) * grid.dr_m), low), high)
        after = cosine * sin_tilt - math.sqrt(1.0 - cosine * cosine) * cos_tilt
        distance = max(grid.edge_m + (j + 0.5) * grid.dr_m, nearest)
        area = bed.gamma[j] * distance * distance * abs(before - after)
        for plane in range(len(out)):
            out[plane, j] += area * two_way(grid.vertical[plane], -before, -after)
        before = after


@compiled
def add_bed(bed: FlatBed, grid: Grid, image: Array) -> None:
    """Add the sea-bed's mean echo, m2, to `image` (beams, samples); it varies little across a beam."""
    beams = len(grid.bearing_rad)
    planes = len(grid.vertical)
    widest = 0.5 * math.pi / grid.beam_width_rad
    width = beam_share(grid.horizontal, -widest, widest) * grid.beam_width_rad
    level = math.hypot(bed.down[0], bed.down[1]) < LEVEL
    column = np.zeros((planes, grid.samples))
    for beam in range(beams):
        if beam == 0 or not level:
            column[:] = 0.0
            bed_column(bed, grid, grid.bearing_rad[beam], column)
        for plane in range(planes):
            row = image[plane * beams + beam]
            for j in range(grid.samples):
                row[j] += width * column[plane, j]


@compiled
def bed_range(bed: FlatBed, x: float, y: float, z: float, far: float) -> float:
    """Return the range at which the ray along (x, y, z) meets the sea-bed, `far` when it does not."""
    sinking = bed.down[0] * x + bed.down[1] * y + bed.down[2] * z
    if bed.height_m <= 0.0 or sinking * far <= bed.height_m:
        return far
    return float(bed.height_m / sinking)
