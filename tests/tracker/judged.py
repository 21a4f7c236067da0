"""The existence model and the life cycle by themselves: tables of tracks through their kernels."""

from collections.abc import Mapping

import msgspec
import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.compiled import native
from ods.tracker.existence.evidence import LENGTH, ExistenceTable, ScanEvidence
from ods.tracker.existence.model import EXISTENCE, MODEL
from ods.tracker.settings import REST, STATIC, EchoSettings, LifeSettings

OLD = 10**12
"""Echoes of a track that is no error of association."""
EVEN = 0.5
"""Probability of rest before anything is known."""


def table(n: int = 1, **rows: float) -> Floats:
    """Return a table of n tracks with these rows of `ExistenceTable`."""
    values = [rows.get(name, 0.0) for name in ExistenceTable._fields]
    return np.repeat(np.array(values)[:, None], n, axis=1)


def take_scan(
    tracks: Floats,
    hit: bool | Mask,
    evidence: Mapping[str, float | Floats],
    *,
    dt: float = 0.0,
    echoes: int = OLD,
    at_rest: float = EVEN,
    confirmed: bool = False,
    counts: Floats | None = None,
) -> ExistenceTable:
    """Update a table of tracks by a scan, of which all but the evidence is the same for all; return its rows.

    evidence: what is not 0 of `ScanEvidence`; counts: of `ClutterStatistics`.
    """
    n, echo = tracks.shape[1], EchoSettings()
    reported = np.stack([np.full(n, 1.0) * evidence.get(name, 0.0) for name in ScanEvidence._fields])
    counted = np.full(n, echoes), np.full(n, confirmed), np.ones(n, bool) & hit
    given = echo.silence_rate, echo.return_rate, echo.loss_rate, echo.detection_probability
    known = np.zeros(LENGTH) if counts is None else counts
    since = dt, 1.0
    native.existence_update(tracks, counted, (reported, np.full(n, at_rest)), since, given, EVEN, known, MODEL)
    return ExistenceTable(*tracks)


def states_after(
    history: Ints, existence: Floats, seen: tuple[Mask, ...], place: tuple[Floats, ...], t_ns: int
) -> Ints:
    """Return the next states of n objects; history, existence: their tables; seen: hit, inside, skipped; place:
    position, variance and shared, (3, n), radius, probability of rest."""
    states, given = np.empty(history.shape[1], np.int64), (t_ns, EXISTENCE.odds_factor, REST, STATIC)
    native.next_states(
        history, existence, seen, place, given, msgspec.structs.astuple(LifeSettings()), states, np.empty(3, np.bool_)
    )
    return states
