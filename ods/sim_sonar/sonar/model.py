"""The simulated sonar: geometry, timing and beam patterns from config/sonars/NAME.toml."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ods.base.arrays import Floats
from ods.base.settings_file import load
from ods.sim_sonar.sonar import patterns
from ods.sim_sonar.sonar.settings import SonarFile, VerticalPattern


@dataclass(frozen=True, eq=False)
class SonarModel:
    """A forward-looking sonar at the vehicle's origin that looks along its bow."""

    name: str
    frequency_hz: float
    sound_speed: float
    bearing_rad: Floats
    """(beams,) planes stacked plane by plane, strictly increasing within a plane."""
    elevation_rad: Floats
    """(beams,) elevation of each beam's plane."""
    planes: int
    beam_width_rad: float
    """Horizontal -3 dB width of a beam."""
    half_vertical_rad: float
    """Half the vertical opening of one plane."""
    range0_m: float
    """Slant range of the first sample's centre."""
    dr_m: float
    samples: int
    overhead_s: float
    vertical_two_way: Floats
    """(planes, patterns.ELEVATION_NODES) S^2 of eq. 5 over the sine of elevation."""
    horizontal_cumulative: Floats
    """Running integral of the horizontal pattern, see patterns.horizontal_cumulative."""
    pixels: tuple[int, int] | None = None
    """Bearings and elevations of range images; none: it sends levels by bearing and range."""

    @property
    def beams(self) -> int:
        """Beams of all planes."""
        return len(self.bearing_rad)

    @property
    def range_max_m(self) -> float:
        """Slant range of the last sample's centre."""
        return self.range0_m + (self.samples - 1) * self.dr_m

    @property
    def ping_period_s(self) -> float:
        """Time from one transmission to the next: the echo's way out and back, and the sonar's overhead."""
        return 2.0 * self.range_max_m / self.sound_speed + self.overhead_s

    @property
    def plane_bearing_rad(self) -> Floats:
        """(beams / planes,) the bearings of one plane."""
        return self.bearing_rad[: self.beams // self.planes]


def load_sonar(path: Path) -> SonarModel:
    """Read a sonar file. Raises ConfigError."""
    return make_sonar(load(path, SonarFile))


def make_sonar(file: SonarFile) -> SonarModel:
    """Build the model that `file` describes."""
    count = file.beams_per_plane
    even = (np.arange(count) - 0.5 * (count - 1)) * file.beam_spacing_deg
    bearing = np.radians(file.bearing_deg if file.bearing_deg else even)
    axes = np.radians(file.plane_elevation_deg)
    return SonarModel(
        name=file.name,
        frequency_hz=file.frequency_hz,
        sound_speed=file.sound_speed,
        bearing_rad=np.tile(bearing, len(axes)),
        elevation_rad=np.repeat(axes, len(bearing)),
        planes=len(axes),
        beam_width_rad=float(np.radians(file.beam_width_deg)),
        half_vertical_rad=float(np.radians(file.half_vertical_deg)),
        range0_m=file.range0_m,
        dr_m=file.dr_m,
        samples=file.samples,
        overhead_s=file.overhead_s,
        vertical_two_way=np.stack([_vertical(file.vertical, axis) for axis in axes]),
        horizontal_cumulative=patterns.horizontal_cumulative(file.side_lobe_db, 360.0 / file.beam_width_deg),
        pixels=file.pixels,
    )


def _vertical(pattern: VerticalPattern, axis_rad: float) -> Floats:
    if pattern.aperture_wavelengths is not None:
        return patterns.aperture_table(pattern.aperture_wavelengths, axis_rad)
    return patterns.two_way_table(pattern.angle_deg, pattern.level_db, axis_rad)
