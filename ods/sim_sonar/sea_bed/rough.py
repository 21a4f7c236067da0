"""A rough sea-bed's echo: columns of steps over its facets, marched outwards from the sonar."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32
from ods.compiled import native
from ods.sim_sonar.echo.bodies.shadow import Shades
from ods.sim_sonar.echo.rays.detail import Detail
from ods.sim_sonar.echo.rays.ray_budget import RayFan
from ods.sim_sonar.sonar.grid import Grid


class RoughBed(NamedTuple):
    """A rough sea-bed as the sonar sees it; its frame is the mean plane's: x, y in the plane, z down."""

    nodes: Floats32
    """See HeightField, as the next three."""
    facet_m: float
    corner_m: tuple[float, float]
    repeats: bool
    sonar_m: Floats
    """(3,) the sonar in the sea-bed's frame; z is negative."""
    turn: Floats
    """(3, 3) from the sonar's frame to the sea-bed's, at transmission."""
    turning: float
    """What the sonar turns about the sea-bed's normal while an echo comes from a metre farther, rad."""
    gamma: Floats
    """Eq. 3 over cos(alpha), even from 0 to 1."""


def add_rough_bed(image: Floats, bed: RoughBed, grid: Grid, scale_m: float, shades: Shades, detail: Detail) -> None:
    """Add the mean echo, m2, of the sea-bed to `image` (beams, samples), less what `shades` hide.

    scale_m: the length over which the echo changes.
    """
    native.add_rough_bed(image, bed, grid, scale_m, shades, detail)


def rough_ranges(bed: RoughBed, rays: RayFan, scale_m: float, within_m: float, detail: Detail) -> Floats:
    """Return the (bearings, elevations) ranges, FAR where there is none, at which rays meet the sea-bed.

    Rays that meet it farther away than `within_m` meet nothing.
    """
    rows, borders = rays.elevation.shape
    ranges = np.empty((rows, borders - 1))
    native.rough_ranges(bed, rays, scale_m, within_m, detail, ranges)
    return ranges
