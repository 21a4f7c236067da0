"""What an image proves: does each object exist, and which state follows from that."""

import math

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.base.clock import NS
from ods.compiled.kernel import kernel
from ods.tracker.association.match import ScanMatch
from ods.tracker.observer.belief import Estimate
from ods.tracker.prediction import ScanPrediction
from ods.tracker.settings import REST, STATIC, TrackerSettings
from ods.tracker.track import doubt, lifecycle, stitching
from ods.tracker.track.lifecycle import Evidence, LifeLimits
from ods.tracker.track.tracks import Tracks, history_rows


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
    known = doubt.assumed(settings.echo, settings.motion, spots)
    judged = match.hit, prediction.reported
    tracks.take_image(judged, prediction.estimate.radius, match.look, match.nothing, known)
    seen = match.hit, prediction.field_of_view.inside, prediction.field_of_view.skipped
    limits = lifecycle.limits_of(settings.life)
    return _next_states(tracks.known, seen, prediction.estimate, t_ns, known.detection_probability, limits)


@kernel
def _next_states(
    known: tuple[Ints, Floats],
    seen: tuple[Mask, Mask, Mask],
    estimate: Estimate,
    t_ns: int,
    detection_probability: float,
    limits: LifeLimits,
) -> Ints:
    """Return (n,) states; `known`: of `Tracks`; `seen`: (n,) hit, and inside and skipped of the field of view."""
    history, d = history_rows(known[0]), doubt.doubt_rows(known[1])
    hit, inside, skipped = seen
    position, radius, static = estimate.position, estimate.radius, estimate.static
    missed, hiding = _missed_and_hiding(history.state, hit, static)
    after = np.empty_like(history.state)
    for i in range(len(after)):
        state, unseen_ns = history.state[i], t_ns - history.last[i]
        rests = state == lifecycle.STAND_BY and static[i] >= STATIC
        young = state == lifecycle.TENTATIVE and hit[i]
        evidence = Evidence(
            hit[i],
            inside[i],
            skipped[i],
            history.echoes[i],
            unseen_ns / NS,
            (unseen_ns - history.unwatched[i]) / NS,
            doubt.proof(d, i) if state == lifecycle.TENTATIVE else d.visible[i] + d.silent[i],
            d.visible[i],
            d.first_visible[i],
            static[i] >= REST,
            rests and stitching.is_covered(i, hiding, position, radius),
            young and stitching.is_duplicate(i, missed, history, position, radius),
            doubt.intermittent(d, i, detection_probability),
            _sigma(estimate, i),
        )
        after[i] = lifecycle.next_state(state, evidence, limits)
    return after


@kernel
def _missed_and_hiding(state: Ints, hit: Mask, static: Floats) -> tuple[Mask, Mask]:
    """Return (n,) the confirmed objects that the image does not show, and those at rest that it does."""
    missed, hiding = np.empty(len(hit), np.bool_), np.empty(len(hit), np.bool_)
    for i in range(len(hit)):
        missed[i] = state[i] != lifecycle.TENTATIVE and not hit[i]
        hiding[i] = state[i] == lifecycle.ACTIVE and hit[i] and static[i] >= STATIC
    return missed, hiding


@kernel
def _sigma(estimate: Estimate, i: int) -> float:
    """Return the larger standard deviation of north and east; of one at rest without what all pings share."""
    moving = 1.0 - estimate.static[i]
    north = estimate.variance[0, i] + moving * estimate.shared[0, i]
    east = estimate.variance[1, i] + moving * estimate.shared[1, i]
    return math.sqrt(max(north, east))
