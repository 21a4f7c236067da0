"""A flat sea-bed's echo: columns in closed form, and what lies between them."""

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.sim_sonar.echo.bodies.shadow import Shades
from ods.sim_sonar.echo.rays.detail import Detail
from ods.sim_sonar.echo.rays.ray_budget import RayFan
from ods.sim_sonar.echo.surface.flat_surface import FlatSurface
from ods.sim_sonar.sonar.grid import Grid


def add_flat_bed(image: Floats, bed: FlatSurface, grid: Grid, shades: Shades, detail: Detail) -> None:
    """Add the mean echo, m2, of the sea-bed to `image` (beams, samples), less what `shades` hide."""
    native.add_flat_bed(image, bed, grid, shades, detail.lean, detail.reach)


def flat_ranges(bed: FlatSurface, rays: RayFan) -> Floats:
    """Return the (bearings, elevations) ranges, FAR where there is none, at which rays meet the sea-bed."""
    rows, borders = rays.elevation.shape
    ranges = np.empty((rows, borders - 1))
    native.flat_ranges(bed, rays, ranges)
    return ranges
