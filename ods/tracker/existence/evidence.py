"""Evidence for the existence of each track, updated once per scan, and what is learned of clutter: see evidence.c."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.tracker.measurement.scan import Echoes, EchoRows

LENGTH = 4
CLUTTER_TRACKS, ENDED_TRACKS, SCANS, ECHOES = range(LENGTH)
"""Places in the array: weighted counts of tracks; scans, and their echoes that no confirmed track explains."""
ROUNDING = 1e-6

SAME_RANGE_M, SAME_BEARING_RAD, SAME_DB = 0.05, 0.005, 0.5
"""An echo that differs by less from one of the scan before is the same."""
MOST = 64
"""Largest number of a scan's echoes that are compared."""
STILL = 0.25
"""Share of such echoes from which on the sonar is at rest: 0.00 to 0.02 under way, 0.54 to 0.98 at rest (simulated)."""
MEMORY = 0.8
"""Share of the sums of echoes that a scan leaves of those before."""
WEIGHT_AT_REST = 0.1
"""Weight of a scan then: only the receiver's noise is another one."""


class ExistenceTable(NamedTuple):
    """Of n tracks: (n,) each. `evidence.h` has the same rows."""

    visible: Floats
    """Probability of an object that returns echoes."""
    silent: Floats
    """Probability of an object that returns none at present."""
    nothing: Floats
    """Probability of no object: false alarms, or an object that is gone."""
    clutter: Floats
    """Probability of persistent clutter."""
    first_visible: Floats
    """`visible` after the first echo."""
    clutter_share: Floats
    """Prior share of persistent clutter among tracks that are no object."""
    hits: Floats
    """Echoes after the first, or since it was recalled from the map,"""
    scans: Floats
    """and scans that could have had one."""
    sharp: Floats
    """Onset: number of sharp echoes,"""
    onsets: Floats
    """number of echoes that measure it;"""
    onset_ratio: Floats
    """log-likelihood ratio applied so far."""
    edges: Floats
    """Leading edge: fading sum of log-odds,"""
    edge_echoes: Floats
    """fading number of echoes,"""
    edge_ratio: Floats
    """log-likelihood ratio applied so far."""
    at_rest: Floats
    """Motion: probability of rest,"""
    rests: Floats
    """1 once that is known;"""
    motion_ratio: Floats
    """log-likelihood ratio applied so far."""


class ScanEvidence(NamedTuple):
    """Evidence of a scan on n tracks: (n,) each."""

    llr: Floats
    """Log-likelihood ratio of the echo: of the object over a false alarm; 0 where there is none."""
    watched: Floats
    """Probability that the object was observed."""
    expected: Floats
    """Probability that a visible object would have had an echo."""
    onset: Floats
    """Of the echo, see `Detection`; 0: none, not measured, or an echo that is not all of the object and only of it."""
    leading_edge: Floats
    """`Detection.front`, likewise."""


class ClutterStatistics:
    """Statistics of clutter with this sonar over this sea-bed: sums and counts with a fading memory."""

    def __init__(self) -> None:
        self.values: Floats = np.zeros(LENGTH)

    def save(self) -> list[float]:
        """Return the array, for a checkpoint."""
        values: list[float] = self.values.tolist()
        return values

    def load(self, values: list[float]) -> None:
        """Restore a saved array. Raises ValueError for an invalid one."""
        found = np.array(values, np.float64)
        if found.shape != (LENGTH,) or not np.isfinite(found).all():
            raise ValueError(f"invalid checkpoint: clutter statistics must be {LENGTH} finite numbers")
        if (found < 0.0).any() or found[CLUTTER_TRACKS] > found[ENDED_TRACKS] * (1.0 + ROUNDING):
            raise ValueError("invalid checkpoint: clutter statistics need counts >= 0, and parts <= totals")
        self.values = found


class Coherence:
    """The weight of a scan as evidence: to a sonar at rest, speckle and crests look as they did before.

    Scans are compared, not poses: an echo that is where it was to a few centimetres, and as strong to half a decibel,
    is the same one again. Under way it is neither: its speckle is another one after some centimetres.
    """

    def __init__(self) -> None:
        self._before: Floats = np.zeros((len(EchoRows._fields), 0))
        self._same, self._all = 0.0, 0.0

    def weight(self, echoes: Echoes) -> float:
        """Return the weight of a scan: 1 under way, `WEIGHT_AT_REST` at rest."""
        same: int = native.count_same_echoes(echoes.table, self._before, MOST, SAME_RANGE_M, SAME_BEARING_RAD, SAME_DB)
        self._same = MEMORY * self._same + same
        self._all = MEMORY * self._all + min(echoes.table.shape[1], MOST)
        self._before = echoes.table
        return WEIGHT_AT_REST if self._same > STILL * self._all else 1.0
