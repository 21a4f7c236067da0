"""A scene's sea-bed: a plane, level or not, with or without a height field on it."""

import math
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.surface.reflection import reflectivity_table
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.sea_bed.height_field import HeightField, height_at, load_field, seeded_field
from ods.sim_sonar.sea_bed.settings import SeaBed


@dataclass(frozen=True, eq=False)
class SeaBedModel:
    """A sea-bed: a plane, and heights above it."""

    depth_m: float
    """Down coordinate of the plane at the origin of NED."""
    axes: Floats
    """(3, 3) matrix from the plane's frame to NED: x and y in the plane, z its downward normal."""
    surface: Surface
    field: HeightField | None
    """None: flat."""
    gamma: Floats
    """Eq. 3 over cos(alpha), even from 0 to 1."""

    def is_above(self, position_ned: Floats) -> bool:
        """Return whether a place, (3,) NED in m, lies above the sea-bed."""
        down, height = self._down_and_height(position_ned)
        return -down > height and down < 0.0

    def height_over(self, position_ned: Floats) -> float:
        """Return how high a place, (3,) NED in m, lies over the sea-bed, m along the plane's normal."""
        down, height = self._down_and_height(position_ned)
        return -down - height

    def altitude_of(self, position_ned: Floats) -> float:
        """Return how far below a place, (3,) NED in m, the sea-bed is, m: of bed and heights that bend little there."""
        return self.height_over(position_ned) / float(self.axes[2, 2])

    def _down_and_height(self, position_ned: Floats) -> tuple[float, float]:
        x, y, down = (position_ned - np.array([0.0, 0.0, self.depth_m])) @ self.axes
        return float(down), 0.0 if self.field is None else float(height_at(self.field, float(x), float(y)))


def make_sea_bed(
    depth_m: float, surface: Surface, field: HeightField | None = None, slope_rad: float = 0.0, toward_rad: float = 0.0
) -> SeaBedModel:
    """Return a sea-bed that falls by `slope_rad` towards heading `toward_rad`, with the heights of `field` on it."""
    gamma = reflectivity_table(surface.cd, surface.cs, math.radians(surface.sigma_deg))
    return SeaBedModel(
        depth_m, _axes(slope_rad, toward_rad), surface, None if field is None or field.slope == 0.0 else field, gamma
    )


def sea_bed_of(settings: SeaBed, scene_seed: int) -> SeaBedModel:
    """Return the sea-bed that a scene file describes. Raises ValueError for an invalid file of heights."""
    slope, toward = math.radians(settings.slope_deg), math.radians(settings.slope_heading_deg)
    field: HeightField | None = None
    if settings.file is not None:
        field = load_field(settings.file)
    elif settings.rough is not None:
        rough = settings.rough
        seed = scene_seed if rough.seed is None else rough.seed
        field = seeded_field(seed, rough.rms_height_m, rough.correlation_m, rough.facets, rough.facet_m)
    return make_sea_bed(settings.depth_m, settings.surface, field, slope, toward)


def _axes(slope: float, toward: float) -> Floats:
    """Return the frame whose x is north and whose y is east when the plane is level."""
    cos_toward, sin_toward = math.cos(toward), math.sin(toward)
    turn = np.array([[cos_toward, -sin_toward, 0.0], [sin_toward, cos_toward, 0.0], [0.0, 0.0, 1.0]])
    cos_slope, sin_slope = math.cos(slope), math.sin(slope)
    lean = np.array([[cos_slope, 0.0, -sin_slope], [0.0, 1.0, 0.0], [sin_slope, 0.0, cos_slope]])
    return np.asarray(turn @ lean @ turn.T)
