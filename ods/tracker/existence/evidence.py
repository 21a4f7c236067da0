"""Evidence for the existence of each track, updated once per scan, and what is learned of clutter: see evidence.c."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled import native
from ods.tracker.existence.model import MODEL
from ods.tracker.measurement.scan import Echoes

LENGTH = 4
CLUTTER_TRACKS, ENDED_TRACKS, SCANS, ECHOES = range(LENGTH)
"""Places in the array: weighted counts of tracks; scans, and their echoes that no confirmed track explains."""
ROUNDING = 1e-9


class ExistenceTable(NamedTuple):
    """Of n tracks: (n,) each. `evidence.h` has the same rows."""

    visible: Floats
    """Probability that there is an object and it gives echoes,"""
    silent: Floats
    """that there is one that gives none just now,"""
    nothing: Floats
    """that there is none,"""
    clutter: Floats
    """and that it is persistent clutter."""
    first_visible: Floats
    """`visible` after the first echo."""
    clutter_share: Floats
    """Share of clutter among what is no object by which it is judged."""
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
    """Probability that the sonar looked at the object,"""
    expected: Floats
    """and that a visible object would have had an echo."""
    onset: Floats
    """Of the echo, see `Detection`; 0: none, not measured, or an echo that is not all of the object and only of it."""
    leading_edge: Floats
    """`Detection.front`, likewise."""


class NewTrackEvidence(NamedTuple):
    """Evidence of k echoes that no track explains: (k,) each."""

    density: Floats
    """False alarms a scan if there were as many everywhere as there."""
    onset: Floats
    """Of the echo; 0: not measured."""
    leading_edge: Floats


class ClutterStatistics:
    """What clutter is like before this bed and this sonar: sums and counts that fade from scan to scan."""

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

    def count(self, echoes: Echoes, free: Mask) -> None:
        """Count the echoes of a scan that no confirmed track explains, (m,) `free`, if they measure a strength."""
        native.clutter_count_echoes(self.values, echoes.table, free, MODEL)

    def learn(self, tracks: Floats, ended: Mask) -> None:
        """Learn from the tracks that a scan ended, (n,), of a table of `ExistenceTable`. Called for every scan."""
        native.clutter_learn(self.values, tracks, ended, MODEL)
