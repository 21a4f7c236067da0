"""Where the columns of a rough sea-bed's echo run and how long their steps are."""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.detail import Detail
from ods.sim_sonar.echo.mixing import add_mean, blended_shares, mix, pattern_width
from ods.sim_sonar.echo.shadow import Shades
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sea_bed.rough import RoughBed, Zone, march
from ods.sim_sonar.sonar.grid import LIT_BEYOND_WIDTHS, Grid

MAX_SPLITS = 5
"""A column is split at most this many times."""


@compiled
def steps_ahead(height_m: float, scale_m: float, farthest_m: float, detail: Detail) -> Floats:
    """Return the ends of the steps from straight below to `farthest_m` ahead, for a sonar `height_m` above the bed."""
    ends = [0.0]
    while ends[-1] < farthest_m:
        here = ends[-1]
        angular = detail.turn * (height_m**2 + here**2) / height_m
        ends.append(here + min(detail.step * scale_m, angular, detail.growth * (here + height_m)))
    return np.array(ends)


def zones_of(grid: Grid, height_m: float, scale_m: float, detail: Detail) -> list[Zone]:
    """Return the rings, from the sonar outwards; each has twice the columns of the one before."""
    farthest = grid.edge_m + grid.samples * grid.dr_m
    ahead = steps_ahead(height_m, scale_m, farthest, detail)
    margin = LIT_BEYOND_WIDTHS * grid.beam_width_rad
    low = max(grid.bearing_rad[0] - margin, -math.pi)
    high = min(grid.bearing_rad[-1] + margin, math.pi)
    count = math.ceil((high - low) / grid.beam_width_rad)
    zones, start = [], 0
    for split in range(MAX_SPLITS + 1):
        widest = detail.spacing * scale_m * count * 2**split / (high - low)
        end = len(ahead) - 1 if split == MAX_SPLITS else int(np.searchsorted(ahead, widest, side="right")) - 1
        if end > start:
            zones.append(Zone(np.linspace(low, high, count * 2**split + 1), ahead[start : end + 1]))
            start = end
        if start == len(ahead) - 1:
            break
    return zones


def add_rough_bed(image: Floats, bed: RoughBed, grid: Grid, scale_m: float, shades: Shades, detail: Detail) -> None:
    """Add the mean echo, m2, of the sea-bed to `image` (beams, samples), less what `shades` hide."""
    height = -float(bed.sonar_m[2])
    horizon = np.full(1, -2.0)
    whole = pattern_width(grid)
    for zone in zones_of(grid, height, scale_m, detail):
        count = len(zone.bearing) - 1
        horizon = np.repeat(horizon, count // len(horizon))
        columns = np.zeros((len(grid.vertical), count, grid.samples))
        first, last = march(bed, grid, zone, horizon, shades, columns)
        if last > first:
            shares = blended_shares(zone.bearing, grid, detail.reach)
            mix(image, columns, first, last, shares)
            add_mean(image, columns, first, last, grid, whole - shares.sum(axis=1))
