"""What false alarms look like: how many an image has, at which ranges and with which radii, counted as they come."""

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.messages import Sector
from ods.tracker.scan import Echoes

RANGES = 10
"""Parts of the sonar's range that are counted apart."""
RADII = 16
"""Classes of radius,"""
RADIUS_STEP_M = 0.5
"""and their width; the last one has all that is larger."""
SLOWEST = 0.03
"""Weight of the newest scan in the long run."""
FEWEST = 0.1
"""False alarms a scan are never taken to be rarer than this."""
PRIOR_SHARE = 0.25
"""Share of an even distribution in what was counted, so that nothing is impossible."""
NEAREST_M = 0.1


class Clutter:
    """Running means over the scans of the echoes that no object explains. The first value counts as one scan."""

    def __init__(self, per_scan: float) -> None:
        self._scans = 1
        self._by_range = np.full(RANGES, per_scan / RANGES)
        self._by_radius = np.full(RADII, per_scan / RADII)

    @property
    def per_scan(self) -> float:
        """False alarms expected in a scan."""
        return max(float(self._by_range.sum()), FEWEST)

    def count(self, unexplained: Echoes, sector: Sector) -> None:
        """Take in the echoes of a scan that belong to no object, confirmed or not."""
        self._scans += 1
        weight = max(1.0 / self._scans, SLOWEST)
        self._by_range += weight * (np.bincount(_range_class(unexplained, sector), minlength=RANGES) - self._by_range)
        self._by_radius += weight * (np.bincount(_radius_class(unexplained), minlength=RADII) - self._by_radius)

    def density(self, echoes: Echoes, sector: Sector) -> Array:
        """Return (m,) false alarms per m^2 at each echo; within a range class all samples are as likely to give one."""
        even = self.per_scan / RANGES
        in_class = PRIOR_SHARE * even + (1.0 - PRIOR_SHARE) * self._by_range
        span_m = (sector.range_max_m - sector.range_min_m) / RANGES
        opening = sector.bearing_max_rad - sector.bearing_min_rad
        per_m_rad = np.maximum(in_class, FEWEST / RANGES)[_range_class(echoes, sector)] / (span_m * opening)
        return np.asarray(per_m_rad / np.maximum(echoes.range_m, NEAREST_M))

    def radius_density(self, echoes: Echoes) -> Array:
        """Return (m,) probability density, 1/m, of each echo's radius among false alarms."""
        share = self._by_radius / max(float(self._by_radius.sum()), 1e-9)
        mixed = PRIOR_SHARE / RADII + (1.0 - PRIOR_SHARE) * share
        return np.asarray(mixed[_radius_class(echoes)] / RADIUS_STEP_M)


def _range_class(echoes: Echoes, sector: Sector) -> NDArray[np.intp]:
    fraction = (echoes.range_m - sector.range_min_m) / (sector.range_max_m - sector.range_min_m)
    return np.minimum(np.maximum(fraction * RANGES, 0), RANGES - 1).astype(np.intp)


def _radius_class(echoes: Echoes) -> NDArray[np.intp]:
    return np.minimum(echoes.radius / RADIUS_STEP_M, RADII - 1).astype(np.intp)
