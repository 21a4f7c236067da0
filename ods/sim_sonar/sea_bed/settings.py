"""The [sea_bed] table of config/scenes/*.toml."""

from pathlib import Path
from typing import Annotated

import msgspec

from ods.base.settings import NonNegative, NonNegativeInt, Positive, Settings
from ods.sim_sonar.echo.surface.settings import Surface


class Roughness(Settings, frozen=True, kw_only=True):
    """Gaussian heights with the correlation exp(-r^2 / correlation_m^2)."""

    rms_height_m: NonNegative
    correlation_m: Positive
    """The rms slope is 1.41 rms_height_m / correlation_m in each direction."""
    seed: NonNegativeInt | None = None
    """The scene's own by default."""
    facets: Annotated[int, msgspec.Meta(ge=8, le=2000)] = 512
    """Along each side of a square that repeats."""
    facet_m: Positive | None = None
    """A quarter of the correlation length by default."""


class SeaBed(Settings, frozen=True, kw_only=True):
    """A plane, with or without heights above it."""

    depth_m: float
    """Down coordinate at north 0, east 0."""
    slope_deg: Annotated[float, msgspec.Meta(ge=0.0, le=30.0)] = 0.0
    """Mean."""
    slope_heading_deg: float = 0.0
    """Heading towards which the plane falls."""
    rough: Roughness | None = None
    file: Path | None = None
    """.npz file of heights instead."""
    surface: Surface = Surface()
    """How it reflects."""

    def __post_init__(self) -> None:
        if self.rough is not None and self.file is not None:
            raise ValueError("rough: set either rough or file")
