"""Existence and state of each object after a scan."""

from typing import NamedTuple

import msgspec
import numpy as np

from ods.base.arrays import Ints, Mask
from ods.compiled import native
from ods.tracker.association.match import ScanMatch
from ods.tracker.existence import lifecycle
from ods.tracker.existence.evidence import ClutterStatistics, Coherence
from ods.tracker.existence.model import EXISTENCE, MODEL
from ods.tracker.measurement.scan import Scan
from ods.tracker.prediction import ScanPrediction
from ods.tracker.settings import REST, STATIC, TrackerSettings
from ods.tracker.track.tracks import Tracks


class Judgement(NamedTuple):
    """Of n objects after a scan."""

    states: Ints
    """(n,) the next state of each."""
    events: Mask
    """(3,) any object is lost out of view, is confirmed, and ends or rests once confirmed."""


def judge(
    tracks: Tracks,
    prediction: ScanPrediction,
    match: ScanMatch,
    clutter: ClutterStatistics,
    coherence: Coherence,
    scan: Scan,
    settings: TrackerSettings,
) -> Judgement:
    """Judge existence by a scan; return what follows for the objects of `tracks`.

    `clutter` learns from the scan: from echoes that no confirmed object explains, and from tracks that it ends.
    """
    (history, existence), echoes, since_s = tracks.known, tracks.history.echoes, tracks.judged_after_s()
    measured = match.evidence.table, tracks.static()
    since, known = (since_s, coherence.weight(scan.echoes)), clutter.values
    native.clutter_count_echoes(known, scan.echoes.table, match.free, MODEL)
    echo, seen = settings.echo, prediction.field_of_view
    counted = echoes, prediction.reported, match.hit
    rates = echo.silence_rate, echo.return_rate, echo.loss_rate, echo.detection_probability
    prior = settings.motion.static_prior
    native.existence_update(existence, counted, measured, since, rates, prior, known, MODEL)
    estimate = prediction.estimate
    states, _ = judged = Judgement(np.empty(len(match.hit), np.int64), np.empty(3, np.bool_))
    shown = match.hit, seen.inside, seen.skipped
    place = estimate.position, estimate.variance, estimate.shared, estimate.radius, estimate.static
    given = scan.t_ns, EXISTENCE.odds_factor, REST, STATIC
    native.next_states(history, existence, shown, place, given, msgspec.structs.astuple(settings.life), judged)
    native.clutter_learn(known, existence, (states == lifecycle.TERMINATED) & seen.inside, MODEL)
    return judged
