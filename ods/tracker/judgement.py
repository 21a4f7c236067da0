"""What an image proves: does each object exist, and which state follows from that."""

import numpy as np

from ods.base.arrays import Ints
from ods.compiled import native
from ods.tracker.association.match import ScanMatch
from ods.tracker.association.onset import DEARER
from ods.tracker.prediction import ScanPrediction
from ods.tracker.settings import REST, STATIC, TrackerSettings
from ods.tracker.track import doubt, lifecycle
from ods.tracker.track.tracks import Tracks


def judge(
    tracks: Tracks,
    prediction: ScanPrediction,
    match: ScanMatch,
    spots: doubt.Spots,
    t_ns: int,
    settings: TrackerSettings,
) -> Ints:
    """Judge existence by the image taken at `t_ns`; return (n,) the next state of each object of `tracks`.

    `spots`: what is known of their echoes.
    """
    known = doubt.assumed(settings.echo, spots)
    judged = match.hit, prediction.reported
    tracks.take_image(judged, match.look, match.nothing, known)
    seen = match.hit, prediction.field_of_view.inside, prediction.field_of_view.skipped
    estimate, states = prediction.estimate, np.empty(len(match.hit), np.int64)
    place = estimate.position, estimate.variance, estimate.shared, estimate.radius, estimate.static
    told = t_ns, DEARER, REST, STATIC
    native.next_states(tracks.known, seen, place, told, lifecycle.limits_of(settings.life), states)
    return states
