"""View of a sea-bed from the sonar in one image: as open water, as a plane or as a height field."""

import math
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.bodies.bodies import FAR
from ods.sim_sonar.echo.bodies.shadow import Shades
from ods.sim_sonar.echo.rays.detail import Detail
from ods.sim_sonar.echo.rays.ray_budget import RayFan
from ods.sim_sonar.echo.surface.flat_surface import FlatSurface, flat_surface
from ods.sim_sonar.sea_bed.flat import add_flat_bed, flat_ranges
from ods.sim_sonar.sea_bed.model import SeaBedModel
from ods.sim_sonar.sea_bed.rough import RoughBed, add_rough_bed, rough_ranges
from ods.sim_sonar.sonar.grid import Grid

MIN_UPRIGHT = 0.15
"""Cosine of the lean against the sea-bed's normal under which a rough sea-bed is drawn as its mean plane."""

STEEP, GENTLEST = 0.1, 1.8
"""Rms slope for which detail_of's laws are made; gentler beds do with steps longer by at most the latter."""


class OpenWater:
    """No sea-bed."""

    def hides_beyond(self, rays: RayFan, grid: Grid) -> Floats:
        """Return (bearings, elevations) ranges at which the sea-bed stops `rays`; FAR where it does not."""
        del grid
        return np.full((rays.elevation.shape[0], rays.elevation.shape[1] - 1), FAR)

    def add_to(self, image: Floats, grid: Grid, shades: Shades) -> None:
        """Add the sea-bed's echo, m2, to `image` (beams, samples), less what `shades` hide."""


@dataclass(frozen=True, eq=False)
class FlatView(OpenWater):
    """A plane."""

    bed: FlatSurface
    detail: Detail

    def hides_beyond(self, rays: RayFan, grid: Grid) -> Floats:
        """See OpenWater."""
        del grid
        return flat_ranges(self.bed, rays)

    def add_to(self, image: Floats, grid: Grid, shades: Shades) -> None:
        """See OpenWater."""
        add_flat_bed(image, self.bed, grid, shades, self.detail)


@dataclass(frozen=True, eq=False)
class RoughView(OpenWater):
    """A height field."""

    bed: RoughBed
    scale_m: float
    """Length over which the echo changes: the heights' correlation length, or more for a gentle bed."""
    detail: Detail

    def hides_beyond(self, rays: RayFan, grid: Grid) -> Floats:
        """See OpenWater."""
        far = min(rays.farthest_m, grid.edge_m + grid.samples * grid.dr_m)
        return rough_ranges(self.bed, rays, self.scale_m, far, self.detail)

    def add_to(self, image: Floats, grid: Grid, shades: Shades) -> None:
        """See OpenWater."""
        add_rough_bed(image, self.bed, grid, self.scale_m, shades, self.detail)


def view_of(
    bed: SeaBedModel | None,
    grid: Grid,
    position_ned: Floats,
    rotation: Floats,
    detail: Detail,
    turning: float = 0.0,
) -> OpenWater:
    """Return `bed` as seen by a sonar at `position_ned` with body-to-global `rotation`; from below it is not seen.

    turning: what the sonar turns to starboard while an echo comes from a metre farther, rad.
    """
    place = np.zeros(3) if bed is None else (position_ned - np.array([0.0, 0.0, bed.depth_m])) @ bed.axes
    height = -float(place[2])
    if bed is None or height <= 0.0:
        return OpenWater()
    turn = bed.axes.T @ rotation
    field = bed.field
    if field is None or turn[2, 2] < MIN_UPRIGHT:
        surface = bed.surface
        reflects = (surface.cd, surface.cs, math.radians(surface.sigma_deg))
        return FlatView(flat_surface(grid, np.ascontiguousarray(turn[2]), height, reflects), detail)
    rough = RoughBed(
        nodes=field.nodes,
        facet_m=field.facet_m,
        corner_m=field.corner_m,
        repeats=field.repeats,
        sonar_m=place,
        turn=np.ascontiguousarray(turn),
        turning=turning,
        gamma=bed.gamma,
    )
    ease = min(GENTLEST, max(1.0, math.sqrt(STEEP / field.slope)))
    return RoughView(rough, ease * field.scale_m, detail)
