"""What clutter is like before this bed and this sonar: learned from the tracks that ended without being objects."""

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled import native
from ods.messages import Sector
from ods.tracker.existence.model import MODEL
from ods.tracker.measurement.scan import Echoes

CLUTTER_TRACKS, ENDED_TRACKS, SCANS, STRENGTHS = range(4)
"""Places in the array: weighted counts of tracks, and scans; then, by ring of range, number, sum and sum of squares of
strengths, dB."""
RINGS = 10
LENGTH = STRENGTHS + 3 * RINGS
ROUNDING = 1e-9


class ClutterStatistics:
    """Sums and counts that fade from scan to scan, in one array."""

    def __init__(self) -> None:
        self.values: Floats = np.zeros(LENGTH)

    def save(self) -> list[float]:
        """Return the array, for a checkpoint."""
        values: list[float] = self.values.tolist()
        return values

    def load(self, values: list[float]) -> None:
        """Go on with a saved array. Raises ValueError for one that cannot be."""
        found = np.array(values, np.float64)
        if found.shape != (LENGTH,) or not np.isfinite(found).all():
            raise ValueError(f"clutter statistics: not {LENGTH} finite numbers")
        counts = np.delete(found, range(STRENGTHS + RINGS, STRENGTHS + 2 * RINGS))
        if (counts < 0.0).any() or found[CLUTTER_TRACKS] > found[ENDED_TRACKS] * (1.0 + ROUNDING):
            raise ValueError("clutter statistics: counts below 0, or a part above its whole")
        self.values = found

    def count_strengths(self, echoes: Echoes, free: Mask, sector: Sector) -> None:
        """Count the echoes of a scan that no confirmed track explains, (m,) `free`."""
        span = sector.range_min_m, sector.range_max_m
        native.clutter_count_strengths(self.values, echoes.table, free, span, MODEL)

    def learn(self, tracks: Floats, ended: Mask) -> None:
        """Learn from the tracks that a scan ended, (n,), of a table of `ExistenceTable`. Called for every scan."""
        native.clutter_learn(self.values, tracks, ended, MODEL)

    @property
    def clutter_share(self) -> float:
        """Share of persistent clutter among what is no object."""
        share: float = native.existence_clutter_share(self.values, MODEL)
        return share

    def crowding(self, dt: float) -> float:
        """Return how crowded clutter is, 0 to 1; `dt`: from the scan before to the newest, s."""
        crowding: float = native.existence_crowding(dt, self.values, MODEL)
        return crowding
