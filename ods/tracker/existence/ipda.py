"""The steps of the existence model for one track, as evidence.c does them for all of a scan: for tests and studies."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.tracker.existence.evidence import ClutterStatistics
from ods.tracker.existence.model import EXISTENCE, MODEL

ONSET, LEADING_EDGE, STRENGTH, MOTION = range(4)
"""Features."""


class ExistenceState(NamedTuple):
    """Probabilities of the four states of one track."""

    visible: float
    silent: float
    nothing: float
    clutter: float


class Rates(NamedTuple):
    """Rates at which an object falls silent, gives echoes again, and is lost, 1/s."""

    silence: float
    recovery: float
    loss: float


class HitRates(NamedTuple):
    """Rate of echoes of a track if it is an object and if it is clutter, over the setting's detection probability."""

    object: float
    clutter: float


def predict(state: ExistenceState, echoes: int, watched: float, dt: float, rates: Rates) -> ExistenceState:
    """Return the probabilities `dt` seconds later; `watched`: share of that time in view; `echoes`: so far."""
    after = np.empty(4)
    native.existence_predict(state, echoes, watched, dt, rates, after)
    return ExistenceState(*after.tolist())


def hit_rate_ratio(hits: float, scans: float, detection_probability: float, crowding: float) -> HitRates:
    """Return the rates of echoes of a track, by its hits in a number of scans."""
    rates = np.empty(2)
    native.existence_hit_rate_ratio(hits, scans, detection_probability, crowding, MODEL, rates)
    return HitRates(*rates.tolist())


def update(state: ExistenceState, hit: bool, llr: float, expected: float, rates: HitRates) -> ExistenceState:
    """Return the probabilities after a scan.

    llr: log-likelihood ratio of the echo, of the object over a false alarm, used where `hit`; expected: probability
    that a visible object would have had an echo.
    """
    after = np.empty(4)
    native.existence_update_one(state, hit, llr, expected, rates, after)
    return ExistenceState(*after.tolist())


def apply_likelihood_ratio(state: ExistenceState, over_nothing: float, over_clutter: float) -> ExistenceState:
    """Return the probabilities given log-likelihood ratios of an object over nothing and over clutter."""
    after = np.empty(4)
    native.existence_apply_likelihood_ratio(state, over_nothing, over_clutter, after)
    return ExistenceState(*after.tolist())


def log_ratio(
    feature: int, echoes: Sequence[float], clutter: ClutterStatistics, range_m: float = 0.5, farthest_m: float = 1.0
) -> float:
    """Return a feature's log-likelihood ratio of an object over clutter, by a track's echoes.

    Motion: by probabilities of rest, of which 0.5 is the one beforehand.
    """
    values = np.array(echoes, np.float64)
    ratio: float = native.existence_log_ratio(feature, values, range_m, 0.0, farthest_m, clutter.values, MODEL)
    return ratio


def confirmation_probability(table: Floats, i: int) -> float:
    """Return the probability by which tentative track i of a table of `ExistenceTable` is confirmed."""
    probability: float = native.existence_confirmation_probability(table, i, EXISTENCE.odds_factor)
    return probability
