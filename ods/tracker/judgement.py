"""What an image proves: does each object exist, and which state follows from that."""

import numpy as np

from ods.base.arrays import Ints
from ods.base.clock import NS
from ods.tracker.association.match import ScanMatch
from ods.tracker.prediction import ScanPrediction
from ods.tracker.settings import REST, TrackerSettings
from ods.tracker.track import existence, lifecycle, stitching
from ods.tracker.track.tracks import Tracks


def judge(tracks: Tracks, prediction: ScanPrediction, match: ScanMatch, t_ns: int, settings: TrackerSettings) -> Ints:
    """Judge existence by the image taken at `t_ns`; return (n,) the next state of each object of `tracks`."""
    history, estimate, hit = tracks.history, prediction.estimate, match.hit
    tentative, probabilities = ~prediction.reported, tracks.probabilities
    carried = existence.carry_on(probabilities, history.echoes, match.watched, tracks.unjudged_s, settings.echo)
    often = existence.returns(tracks.looks.hits, tracks.looks.looks, settings.echo.detection_probability)
    probabilities[...] = existence.after_image(carried, hit, match.llr, match.expected, often)
    tracks.compare(match.strength, match.typical, match.spots, settings.motion.static_prior)
    tracks.looked(hit, match.watched, existence.SPOT_SEEN * match.spots)
    tracks.unjudged_s = 0.0
    evidence = lifecycle.Evidence(
        hit=hit,
        inside=prediction.field_of_view.inside,
        skipped=prediction.field_of_view.skipped,
        echoes=history.echoes,
        unseen_s=(t_ns - history.last) / NS,
        missed_s=(t_ns - history.last - history.unwatched) / NS,
        existence=tracks.existence,
        visible=tracks.doubt.visible,
        first_visible=tracks.doubt.first_visible,
        static=estimate.static >= REST,
        covered=stitching.covered(
            estimate, history.state == lifecycle.STAND_BY, hit & (history.state == lifecycle.ACTIVE)
        ),
        duplicate=stitching.duplicates(history, estimate, tentative & hit, prediction.reported & ~hit),
        intermittent=tracks.intermittent(settings.echo.detection_probability),
        sigma=np.sqrt((estimate.variance[:2] + (1.0 - estimate.static) * estimate.shared[:2]).max(axis=0)),
    )
    return lifecycle.next_states(history.state, evidence, settings.life)
