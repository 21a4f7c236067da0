"""Existence and state of each object after a scan."""

from typing import NamedTuple

import msgspec
import numpy as np

from ods.base.arrays import Ints, Mask
from ods.compiled import native
from ods.tracker.association.match import ScanMatch
from ods.tracker.existence import lifecycle
from ods.tracker.existence.evidence import ClutterStatistics
from ods.tracker.existence.model import EXISTENCE
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
    scan: Scan,
    weight: float,
    settings: TrackerSettings,
) -> Judgement:
    """Judge existence by a scan of this weight; return what follows for the objects of `tracks`.

    `clutter` learns from the scan: from echoes that no confirmed object explains, and from tracks that it ends.
    """
    clutter.count(scan.echoes, match.free)
    tracks.take_scan((prediction.reported, match.hit), match.evidence, weight, settings, clutter)
    history, existence = tracks.known
    seen = match.hit, prediction.field_of_view.inside, prediction.field_of_view.skipped
    estimate = prediction.estimate
    states, _ = judged = Judgement(np.empty(len(match.hit), np.int64), np.empty(3, np.bool_))
    place = estimate.position, estimate.variance, estimate.shared, estimate.radius, estimate.static
    given = scan.t_ns, EXISTENCE.odds_factor, REST, STATIC
    native.next_states(history, existence, seen, place, given, msgspec.structs.astuple(settings.life), judged)
    clutter.learn(existence, (states == lifecycle.TERMINATED) & prediction.field_of_view.inside)
    return judged
