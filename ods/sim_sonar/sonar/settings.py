"""Settings in config/sonars/*.toml."""

from itertools import pairwise
from typing import Annotated

import msgspec

from ods.base.settings import NonNegative, Positive, Settings, unit

Degrees90 = Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)]
Pixels = Annotated[int, msgspec.Meta(ge=2, le=1024)]
Level = Annotated[float, msgspec.Meta(le=0.0)]


class VerticalPattern(Settings, frozen=True, kw_only=True):
    """S^2 of eq. 5, two-way, symmetric about the axis; by default the shape of figure 8."""

    angle_deg: list[float] = msgspec.field(
        default_factory=lambda: [0, 3, 6, 8, 10, 11, 12, 13, 14, 15.5, 17, 20, 24, 34, 42, 52, 65, 90]
    )
    """From the axis, strictly increasing from 0."""
    level_db: list[Level] = msgspec.field(
        default_factory=lambda: [0, -0.5, -2, -3.7, -6, -10, -16, -24, -33, -35, -29, -26, -25, -26, -29, -33, -40, -55]
    )
    """At those angles, 0 at the first; held beyond the last."""
    aperture_wavelengths: Annotated[float, msgspec.Meta(gt=0.0, le=200.0)] | None = None
    """Instead: height of a uniform aperture for sending and receiving."""

    def __post_init__(self) -> None:
        if len(self.angle_deg) != len(self.level_db) or len(self.angle_deg) < 2:
            raise ValueError("vertical: angle_deg and level_db must have the same length, at least 2")
        if self.angle_deg[0] != 0.0 or any(b <= a for a, b in pairwise(self.angle_deg)):
            raise ValueError("vertical: angle_deg must increase strictly from 0")
        if self.level_db[0] != 0.0:
            raise ValueError("vertical: level_db must start at 0")


class SonarFile(Settings, frozen=True, kw_only=True):
    """A forward-looking sonar: config/sonars/NAME.toml."""

    name: str
    frequency_hz: Positive
    """Carrier."""
    sound_speed: Annotated[float, msgspec.Meta(ge=1300.0, le=1700.0), unit("m/s")] = 1500.0
    """m/s."""
    beams_per_plane: Annotated[int, msgspec.Meta(ge=1, le=4096)] = 1
    """Evenly spaced about straight ahead; not read with bearing_deg."""
    beam_spacing_deg: Positive = 1.0
    """Not read with bearing_deg."""
    bearing_deg: list[Annotated[float, msgspec.Meta(gt=-180.0, lt=180.0)]] = msgspec.field(default_factory=list)
    """Of one plane's beams, strictly increasing."""
    plane_elevation_deg: Annotated[list[Degrees90], msgspec.Meta(min_length=1, max_length=64)] = msgspec.field(
        default_factory=lambda: [0.0]
    )
    """Of each plane's axis, up positive."""
    beam_width_deg: Annotated[float, msgspec.Meta(gt=0.0, le=90.0)]
    """Horizontal, -3 dB."""
    side_lobe_db: Annotated[float, msgspec.Meta(ge=-60.0, le=-13.3)] = -25.0
    """Highest horizontal side lobe, below the main lobe."""
    half_vertical_deg: Annotated[float, msgspec.Meta(gt=0.0, le=90.0)] = 10.0
    """Half the vertical opening of one plane's main lobe."""
    vertical: VerticalPattern = VerticalPattern()
    """Two-way vertical pattern."""
    range0_m: Positive
    """Slant range of the first sample's centre."""
    dr_m: Positive
    """Sample spacing, slant range."""
    samples: Annotated[int, msgspec.Meta(ge=1, le=65536)]
    """Of each beam."""
    pixels: tuple[Pixels, Pixels] | None = None
    """Bearings and elevations of a 3-D sonar."""
    overhead_s: NonNegative = 0.0
    """From the last sample to the next transmission."""

    def __post_init__(self) -> None:
        if any(b <= a for a, b in pairwise(self.bearing_deg)):
            raise ValueError("bearing_deg: must increase strictly")
        span = (self.beams_per_plane - 1) * self.beam_spacing_deg
        if not self.bearing_deg and span >= 360.0:
            raise ValueError(f"beam_spacing_deg: {self.beams_per_plane} beams would span {span:g} degrees")
        beams = len(self.bearing_deg) or self.beams_per_plane
        if beams * len(self.plane_elevation_deg) > 4096:
            raise ValueError("plane_elevation_deg: more than 4096 beams in all")
