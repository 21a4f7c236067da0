"""Range to which a 3-D sonar observed each direction: objects behind the nearest echo are hidden."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.messages import Detections


class ObservedRanges(NamedTuple):
    """Cells of equal angles, in the frame of the sonar's head."""

    clear_m: Floats
    """(bearings, elevations) slant range of the nearest echo; the largest range where there is none."""
    bearings_rad: tuple[float, float]
    """First and last border,"""
    elevations_rad: tuple[float, float]
    """likewise, up positive."""

    def nearest(self, bearing: Floats, elevation: Floats) -> Floats:
        """Return (...) `clear_m` in these directions; infinite beyond the borders."""
        column = _cell(bearing, self.bearings_rad, self.clear_m.shape[0])
        row = _cell(elevation, self.elevations_rad, self.clear_m.shape[1])
        found = self.clear_m[np.maximum(column, 0), np.maximum(row, 0)]
        return np.asarray(np.where((column >= 0) & (row >= 0), found, np.inf))

    def hides(self, range_m: Floats, bearing: Floats, elevation: Floats, margin_m: Floats) -> Mask:
        """Return (...) bool: points farther behind the nearest echo in their direction than the margin."""
        return np.asarray(self.nearest(bearing, elevation) < range_m - margin_m)


def observed_ranges_of(message: Detections) -> ObservedRanges | None:
    """Return what a ping saw; None if that is not reported, or invalid."""
    volume, sector = message.looked_volume, message.sector
    if volume is None or len(volume.clear_m) != 4 * volume.bearings * volume.elevations:
        return None
    clear_m = np.frombuffer(volume.clear_m, "<f4").astype(np.float64).reshape(volume.bearings, volume.elevations)
    bearings = sector.bearing_min_rad, sector.bearing_max_rad
    elevations = volume.elevation_min_rad, volume.elevation_max_rad
    if not (bearings[0] < bearings[1] and elevations[0] < elevations[1] and math.isfinite(float(clear_m.sum()))):
        return None
    return ObservedRanges(clear_m, bearings, elevations)


def _cell(angle: Floats, borders: tuple[float, float], count: int) -> Indices:
    """Return the number of the cell, -1: of none."""
    place = (np.asarray(angle) - borders[0]) * (count / (borders[1] - borders[0]))
    inside = (place >= 0.0) & (place <= count)  # false for NaN
    return np.where(inside, np.minimum(np.where(inside, place, 0.0).astype(np.intp), count - 1), -1)
