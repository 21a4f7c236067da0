"""What false alarms look like: how many an image has, at which ranges and with which radii, counted as they come."""

from collections.abc import Sequence

import numpy as np

from ods.base.arrays import Floats
from ods.base.kernel import kernel
from ods.messages import Sector
from ods.tracker.association.gnn import ClutterDensity
from ods.tracker.measurement.scan import RADIUS, RANGE, Echoes

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
LEAST_MEAN = 1e-9
"""Keeps shares of a sum that has fallen to nothing finite."""
ALL_LOOKED = np.ones(RANGES)
NEAREST_M = 0.1


class Clutter:
    """Running means over the scans of the echoes that no object explains. The first value counts as one scan."""

    def __init__(self, per_scan: float) -> None:
        self._scans = 1
        self._mean = per_scan
        self._by_range = np.full(RANGES, per_scan / RANGES)
        self._by_radius = np.full(RADII, per_scan / RADII)

    @property
    def per_scan(self) -> float:
        """False alarms expected in a scan."""
        return max(self._mean, FEWEST)

    def count(self, unexplained: Echoes, sector: Sector, looked: Sequence[tuple[float, float]]) -> None:
        """Take in the echoes of a scan that belong to no object, confirmed or not.

        looked: ranges (from, to) that were processed; empty: all. What is counted is what a look at all of them has.
        """
        self._scans += 1
        weight = max(1.0 / self._scans, SLOWEST)
        share = _share_looked(sector, looked)
        edges = sector.range_min_m, sector.range_max_m
        self._mean = _count(unexplained.table, *edges, weight, share, self._by_range, self._by_radius)

    def density(self, echoes: Echoes, sector: Sector) -> ClutterDensity:
        """Return false alarms at each echo; within a range class all samples are as likely to give one."""
        edges = sector.range_min_m, sector.range_max_m
        opening = sector.bearing_max_rad - sector.bearing_min_rad
        density = _density(echoes.table, *edges, opening, self._mean, self._by_range, self._by_radius)
        return ClutterDensity(density[0], density[1])


@kernel
def _count(
    echoes: Floats, nearest: float, farthest: float, weight: float, looked: Floats, by_range: Floats, by_radius: Floats
) -> float:
    """Move the running means by `weight` towards the counts of this scan, in place; return the sum of `by_range`.

    looked: (RANGES,) share of each class of range that was processed: what was not stays as it is.
    """
    by_range *= 1.0 - weight * looked
    by_radius *= 1.0 - weight
    for j in range(echoes.shape[1]):
        by_range[_range_class(echoes[RANGE, j], nearest, farthest)] += weight
        by_radius[_radius_class(echoes[RADIUS, j])] += weight
    return float(by_range.sum())


@kernel
def _density(
    echoes: Floats, nearest: float, farthest: float, opening: float, mean: float, by_range: Floats, by_radius: Floats
) -> Floats:
    """Return the (2, m) fields of `ClutterDensity`; `mean`: the sum of `by_range`."""
    radii = max(by_radius.sum(), LEAST_MEAN)
    area = (farthest - nearest) / RANGES * opening
    density = np.empty((2, echoes.shape[1]))
    for j in range(echoes.shape[1]):
        distance = echoes[RANGE, j]
        counted = by_range[_range_class(distance, nearest, farthest)]
        in_class = PRIOR_SHARE * max(mean, FEWEST) / RANGES + (1.0 - PRIOR_SHARE) * counted
        density[0, j] = max(in_class, FEWEST / RANGES) / (area * max(distance, NEAREST_M))
        share = by_radius[_radius_class(echoes[RADIUS, j])] / radii
        density[1, j] = (PRIOR_SHARE / RADII + (1.0 - PRIOR_SHARE) * share) / RADIUS_STEP_M
    return density


@kernel
def _range_class(distance: float, nearest: float, farthest: float) -> int:
    fraction = (distance - nearest) / (farthest - nearest)
    return int(min(fraction * RANGES, RANGES - 1.0)) if fraction > 0.0 else 0


@kernel
def _radius_class(radius: float) -> int:
    return int(min(radius / RADIUS_STEP_M, RADII - 1.0)) if radius > 0.0 else 0


def _share_looked(sector: Sector, looked: Sequence[tuple[float, float]]) -> Floats:
    """Return (RANGES,) the share of each class of range that was processed."""
    if not looked:
        return ALL_LOOKED
    edges = np.linspace(sector.range_min_m, sector.range_max_m, RANGES + 1)
    covered = sum(np.diff(np.clip(edges, begin, stop)) for begin, stop in looked)
    return np.asarray(covered / np.diff(edges))
