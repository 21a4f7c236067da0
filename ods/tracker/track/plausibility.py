"""Validation of tracks restored from a checkpoint: one wrong number would spoil all that follows."""

import numpy as np

from ods.tracker.existence import lifecycle
from ods.tracker.existence.evidence import ROUNDING
from ods.tracker.track.tracks import Tracks

FARTHEST = 1e9
"""Largest number of a filter, in any of their units, and largest time since existence was judged, s."""
SMALLEST_RADIUS_M = 10.0
"""Filters know of no bounds: a radius may fall a little below 0."""


def validate_tracks(tracks: Tracks, t_ns: int) -> None:
    """Raise ValueError when a history, a probability or a filter cannot be, at the time `t_ns`."""
    _validate_histories(tracks, t_ns)
    known = tracks.judged
    chances = np.stack([known.visible, known.silent, known.nothing, known.clutter, known.first_visible])
    if not ((chances >= 0.0) & (chances <= 1.0 + ROUNDING)).all() or not 0.0 <= tracks.unjudged_s < FARTHEST:
        raise ValueError("invalid checkpoint: probabilities must be between 0 and 1")
    if not ((known.hits >= 0.0) & (known.hits <= known.scans * (1.0 + ROUNDING))).all():
        raise ValueError("invalid checkpoint: scans must be finite and >= hits")
    counts, share = np.stack([known.onsets, known.edge_echoes]), known.clutter_share
    bounded = (np.abs(np.stack(known)) < FARTHEST).all()
    if not bounded or not (counts >= 0.0).all() or not ((share > 0.0) & (share < 1.0)).all():
        raise ValueError("invalid checkpoint: features must be finite, counts >= 0, and shares of clutter in (0, 1)")
    _validate_filters(tracks)


def _validate_histories(tracks: Tracks, t_ns: int) -> None:
    history = tracks.history
    ids = history.id[history.id != 0]
    named = (history.id > 0) == (history.state != lifecycle.TENTATIVE)
    states = (history.state >= lifecycle.TENTATIVE) & (history.state <= lifecycle.HIBERNATED)
    times = (history.born <= history.last) & (history.last <= t_ns) & (history.unwatched >= 0)
    if not (named & states & times & (history.echoes >= 1)).all() or len(np.unique(ids)) != len(ids):
        raise ValueError("invalid checkpoint: ids, states and times of tracks contradict each other")


def _validate_filters(tracks: Tracks) -> None:
    tables = [each.table for each in tracks.tables[2:]]
    if any(np.isnan(table).any() or (np.abs(table[np.isfinite(table)]) > FARTHEST).any() for table in tables):
        raise ValueError(f"invalid checkpoint: filter states must be numbers within {FARTHEST:g}")
    with np.errstate(all="ignore"):  # infinite ones, which only the odds of rest may be, spoil the moments
        (belief, estimate), (velocity, velocity_variance) = tracks.belief_and_moments(), tracks.velocity()
        moments = [velocity, velocity_variance, *estimate]
        limit = belief.variance[:, 0] * belief.variance[:, 1] * (1.0 + ROUNDING)
    if not all(np.isfinite(array).all() for array in moments) or not (belief.radius > -SMALLEST_RADIUS_M).all():
        raise ValueError("invalid checkpoint: means and variances must be finite")
    positive = (belief.variance > 0.0).all() and (belief.radius_variance > 0.0).all()
    positive &= (velocity_variance >= 0.0).all() and (belief.covariance_ne**2 <= limit).all()
    whole = (belief.weight >= 0.0).all() and (np.abs(belief.weight.sum(axis=0) - 1.0) < ROUNDING).all()
    if not positive or not whole:
        raise ValueError("invalid checkpoint: variances must be positive, and weights sum to 1")
