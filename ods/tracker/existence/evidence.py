"""Evidence for the existence of each track, updated once per scan: the table, and the loop over it (existence.c)."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.compiled import native
from ods.messages import Sector
from ods.tracker.existence.clutter_statistics import ClutterStatistics
from ods.tracker.existence.model import MODEL
from ods.tracker.settings import TrackerSettings


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
    looks: Floats
    """and scans that could have had one."""
    sharp: Floats
    """Onset: number of sharp echoes,"""
    onsets: Floats
    """of so many that measure it;"""
    onset_ratio: Floats
    """log-likelihood ratio applied so far."""
    edges: Floats
    """Leading edge: fading sum of log-odds,"""
    edge_echoes: Floats
    """fading number of echoes,"""
    edge_ratio: Floats
    """log-likelihood ratio applied so far."""
    strengths: Floats
    """Strength: sum of (strength - mean of clutter) / standard deviation of clutter,"""
    strength_echoes: Floats
    """number of echoes,"""
    strength_ratio: Floats
    """log-likelihood ratio applied so far."""
    at_rest: Floats
    """Motion: probability of rest,"""
    rests: Floats
    """1 once that is known;"""
    motion_ratio: Floats
    """log-likelihood ratio applied so far."""


class ScanEvidence(NamedTuple):
    """What a scan shows of n tracks: (n,) each."""

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
    strength: Floats
    """Of the echo, dB; 0: none, or not measured."""


class NewTrackEvidence(NamedTuple):
    """What is known of k echoes that no track explains: (k,) each."""

    density: Floats
    """False alarms a scan if there were as many everywhere as there."""
    range_m: Floats
    onset: Floats
    """Of the echo; 0: not measured."""
    leading_edge: Floats
    strength: Floats


def begin(
    table: Floats, first: int, births: float, new: NewTrackEvidence, sector: Sector, clutter: ClutterStatistics
) -> None:
    """Set tracks from `first` on in a table of `ExistenceTable`, one an unexplained echo, given births a scan."""
    span = sector.range_min_m, sector.range_max_m
    native.existence_begin(table, first, births, new, span, clutter.values, MODEL)


def update(
    table: Floats,
    seen: tuple[Ints, Mask, Mask],
    evidence: tuple[Floats, Floats],
    places: tuple[Floats, Sector],
    dt: float,
    settings: TrackerSettings,
    clutter: ClutterStatistics,
) -> None:
    """Judge by a scan, `dt` seconds after the one before; `table`: of `ExistenceTable`.

    seen: (n,) echoes so far, this one too, which tracks are confirmed, and which had an echo; evidence: table of
    `ScanEvidence`, and (n,) probability of rest; places: (n,) expected ranges, m, and the fan that they are in.
    """
    range_m, sector = places
    span = sector.range_min_m, sector.range_max_m
    echo = settings.echo
    rates = echo.silence_rate, echo.return_rate, echo.loss_rate, echo.detection_probability
    given = rates, settings.motion.static_prior
    native.existence_update(table, seen, evidence, range_m, span, dt, *given, clutter.values, MODEL)


def visibilities(table: Floats, returned: float) -> Floats:
    """Return (n,) the probability that an object, if it exists, gives echoes; `returned`: that a silent one does."""
    found = np.empty(table.shape[1])
    native.existence_visibilities(table, returned, found)
    return found
