"""The geometry of an image of one plane of beams, as stages see it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ods.base.arrays import Floats


@dataclass(frozen=True, eq=False)
class Fan:
    """Positions of an image's cells: row b is at bearing_rad[b], column j at range_m[j]."""

    bearing_rad: Floats
    """(beams,) strictly increasing, starboard positive."""
    beam_width_rad: Floats
    """(beams,) horizontal -3 dB width."""
    samples: int
    range0_m: float
    """Slant range of the first column's centre."""
    dr_m: float
    """Column spacing in slant range."""
    elevation_rad: float = 0.0
    """Elevation of the plane, up positive."""
    seam: int | None = None
    """Column before which ranges are left out, where an image shows two rings of ranges side by side,"""
    skipped_m: float = 0.0
    """and how much is left out there."""

    @property
    def shape(self) -> tuple[int, int]:
        """Return (beams, samples)."""
        return len(self.bearing_rad), self.samples

    @cached_property
    def range_m(self) -> Floats:
        """Return the (samples,) slant ranges of the columns' centres."""
        ranges: Floats = self.range0_m + self.dr_m * np.arange(self.samples, dtype=np.float64)
        ranges[self.seam or self.samples :] += self.skipped_m
        return ranges

    @cached_property
    def borders_rad(self) -> Floats:
        """Return the (beams + 1,) bearings that part the beams."""
        return beam_borders(self.bearing_rad, float(self.beam_width_rad[0]))

    @cached_property
    def table(self) -> tuple[Floats, Floats, Floats, float, float, float]:
        """Return what kernels get of it: `FanTable` of fan.h."""
        return self.bearing_rad, self.borders_rad, self.beam_width_rad, self.range0_m, self.dr_m, self.elevation_rad


def beam_borders(bearing_rad: Floats, lone_width_rad: float) -> Floats:
    """Return the (beams + 1,) bearings that part the beams: half-way between them, as far outside at the ends.

    A lone beam is as wide as `lone_width_rad`.
    """
    if len(bearing_rad) == 1:
        return np.array([bearing_rad[0] - 0.5 * lone_width_rad, bearing_rad[0] + 0.5 * lone_width_rad])
    middle = 0.5 * (bearing_rad[1:] + bearing_rad[:-1])
    return np.concatenate(([2.0 * bearing_rad[0] - middle[0]], middle, [2.0 * bearing_rad[-1] - middle[-1]]))
