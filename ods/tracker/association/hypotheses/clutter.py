"""Clutter statistics: number per image, distribution over the fan, and radii, estimated from unexplained echoes."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.messages import Sector
from ods.tracker.measurement.scan import Echoes
from ods.tracker.restart.state import ClutterState

RANGES, BEARINGS = 10, 6
"""Parts of the fan that are counted apart."""
RADII = 16
"""Classes of radius."""
SLOWEST = 0.03
"""Weight of the newest scan in the long run."""
FEWEST = 0.1
"""False alarms a scan are never taken to be rarer than this."""
ALL_PROCESSED = np.ones(RANGES)


class ClutterDensity(NamedTuple):
    """False alarms at the place of each of m echoes."""

    per_m2: Floats
    """(m,) false alarms per scan and m^2."""
    per_scan: Floats
    """(m,) false alarms per scan, if the whole fan had the density at this echo."""
    radius: Floats
    """(m,) probability density of the echo's radius among them, 1/m."""


class _Span(NamedTuple):
    nearest: float
    farthest: float
    port: float
    """rad,"""
    opening: float
    """rad."""


def _span_of(sector: Sector) -> _Span:
    return _Span(
        sector.range_min_m, sector.range_max_m, sector.bearing_min_rad, sector.bearing_max_rad - sector.bearing_min_rad
    )


class Clutter:
    """Running means, over scans, of the echoes that no object explains. The prior counts as one scan."""

    def __init__(self, per_scan: float) -> None:
        self._scans = 1
        self._mean = per_scan
        self._by_part = np.full((RANGES, BEARINGS), per_scan / (RANGES * BEARINGS))
        self._by_radius = np.full(RADII, per_scan / RADII)

    def state(self) -> ClutterState:
        """Return what was counted."""
        return ClutterState(self._scans, float(self._mean), self._by_part.ravel().tolist(), self._by_radius.tolist())

    def restore(self, state: ClutterState) -> None:
        """Restore the counts of another one. Raises ValueError."""
        counts = np.array([state.scans, state.mean, *state.by_part, *state.by_radius], np.float64)
        parts = RANGES * BEARINGS
        if len(counts) != 2 + parts + RADII or not (np.isfinite(counts) & (counts >= 0.0)).all() or state.scans < 1:
            raise ValueError("invalid checkpoint: counts of clutter must be finite and >= 0")
        self._scans, self._mean = state.scans, state.mean
        self._by_part = counts[2 : 2 + parts].reshape(RANGES, BEARINGS)
        self._by_radius = counts[2 + parts :]

    @property
    def per_scan(self) -> float:
        """False alarms expected in a scan."""
        return max(self._mean, FEWEST)

    def count(
        self, unexplained: Echoes, sector: Sector, processed_ranges_m: Sequence[tuple[float, float]] = ()
    ) -> None:
        """Take in the echoes of a scan that belong to no object, confirmed or not.

        processed_ranges_m: see `Scan`. What is counted is what an image of all ranges has.
        """
        self._scans += 1
        weight = max(1.0 / self._scans, SLOWEST)
        share = _share_processed(sector, processed_ranges_m)
        span = _span_of(sector)
        self._mean = native.clutter_count(unexplained.table, span, weight, share, self._by_part, self._by_radius)

    def density(self, echoes: Echoes, sector: Sector) -> ClutterDensity:
        """Return false alarms at each echo; within a part of the fan all samples are as likely to give one."""
        table = np.empty((len(ClutterDensity._fields), echoes.table.shape[1]))
        native.clutter_density(echoes.table, _span_of(sector), self._by_part, self._by_radius, FEWEST, table)
        return ClutterDensity(*table)


def _share_processed(sector: Sector, ranges_m: Sequence[tuple[float, float]]) -> Floats:
    """Return (RANGES,) the share of each class of range that was processed."""
    if not ranges_m:
        return ALL_PROCESSED
    edges = np.linspace(sector.range_min_m, sector.range_max_m, RANGES + 1)
    covered = sum(np.diff(np.clip(edges, begin, stop)) for begin, stop in ranges_m)
    return np.asarray(covered / np.diff(edges))
