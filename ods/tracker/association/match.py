"""What one image says about the objects: which echo is whose, who was missed, which echoes are of nobody."""

import math
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats, Indices, Ints, Mask
from ods.base.kernel import kernel
from ods.tracker.association import gnn, split_merged
from ods.tracker.association.gnn import Candidates, ClutterDensity, Pairing
from ods.tracker.association.registry import Association
from ods.tracker.measurement import model
from ods.tracker.measurement.field_of_view import View, hidden, near_sector, view
from ods.tracker.measurement.model import Fix, Sight
from ods.tracker.measurement.scan import Echoes, Scan, Vehicle
from ods.tracker.observer.belief import Belief, Estimate
from ods.tracker.settings import TrackerSettings
from ods.tracker.track import lifecycle

DROP_OUT_EXPECTED = 3.0
"""So many confirmed objects expected,"""
DROP_OUT_SHARE = 0.25
"""and no more than this share of them seen: a drop-out of the image, which counts against nobody,"""
DROP_OUT_DETECTION = 0.005
"""and in which an object has an echo with this probability: what is found is more likely a false alarm."""
SILENT_S = 0.5
"""An object seen more recently than this is not silent; one behind another is then seen over it or beside it."""
VAGUE_M = 1.0
"""An object silent for so long that its place is less certain than this takes no single echo, which may be a false
alarm: it is found again by a new object that is confirmed there."""
WAKE_MARGIN_M = 5.0
"""Hibernated objects join the live ones so near to the sector's edge, and sleep again at twice that distance."""
NO_RADIUS = 1e6
"""Variance of a radius that was not measured, m^2."""


@dataclass(frozen=True, slots=True)
class Look:
    """n objects, of which k were seen."""

    objects: Indices
    """(k,) the objects seen, each once,"""
    fix: Fix
    """and where (k,)."""
    hit: Mask
    """(n,) seen."""
    watched: Floats
    """(n,) probability that the sonar looked at the object,"""
    expected: Floats
    """and that a visible object would have given an echo; 0 in a drop-out."""
    evidence: Floats
    """(n,) log-likelihood ratio of the echo: object against false alarm; 0 where not hit."""
    inside: Mask
    """(n,) the predicted place is in the sonar's view,"""
    skipped: Mask
    """(n,) but at a range that was not processed in this image."""
    near: Mask
    """(n,) it is in view or, for hibernated objects, not far from it."""
    new: Indices
    """Echoes that no object explains."""


def look(
    scan: Scan,
    vehicle: Vehicle,
    belief: Belief,
    estimate: Estimate,
    state: Ints,
    unseen_s: Floats,
    visibility: Floats,
    clutter: ClutterDensity,
    settings: TrackerSettings,
    associate: Association,
) -> Look:
    """Compare an image with the predictions of n objects: their hypotheses `belief`, and `estimate`, the mixture.

    `state`: (n,) a state of `life`; `unseen_s`: (n,) time since the last echo; `visibility`: (n,) of `existence`;
    `associate`: of `associations`.
    """
    sights = model.sight(belief.position, belief.variance, belief.covariance_ne, vehicle)
    sight = model.sight(estimate.position, estimate.variance, estimate.covariance_ne, vehicle)
    seen = view(sight, scan.sector, scan.looked, settings.life.edge_sigmas, scan.fan_turn)
    reported = state != lifecycle.TENTATIVE
    silent = reported & (unseen_s > SILENT_S)
    seen.watched[silent & hidden(sight, estimate.radius, state == lifecycle.ACTIVE)] = 0.0
    found = gnn.candidates(sights, belief, scan.echoes, clutter, settings.echo)
    vague = silent & (np.maximum(sight.along, sight.across) > VAGUE_M**2)
    found = found.take(~vague[found.objects])
    visible = visibility * seen.probability
    detected = settings.echo.detection_probability
    worth = gnn.worth_of(found, visible, detected)
    pairing = associate(found, worth, reported, scan.echoes, sight, estimate)
    drop_out = _is_drop_out(seen, reported, pairing.pairs)
    if drop_out:
        found = found._replace(evidence=found.evidence + math.log(DROP_OUT_DETECTION / detected))
        detected = DROP_OUT_DETECTION
        worth = gnn.worth_of(found, visible, detected)
        pairing = associate(found, worth, reported, scan.echoes, sight, estimate)
    parts, loose = _parts(scan.echoes, pairing.explained, sight, estimate.radius, reported)
    shown = _shown(scan.echoes, pairing, _likely(parts, estimate.radius, clutter, visible, detected), estimate.radius)
    hit = np.zeros(len(state), bool)
    hit[shown.objects] = True
    merged = split_merged.merged(estimate, hit, reported & (seen.watched > 0.0))
    watched = _watched(seen, reported, hit, merged)
    asleep = state == lifecycle.HIBERNATED
    return Look(
        objects=shown.objects,
        fix=_fix(scan, vehicle, sight, shown, shown.off_centre + merged[shown.objects]),
        hit=hit,
        evidence=np.asarray(np.bincount(shown.objects, shown.evidence, len(state)), np.float64),
        watched=watched,
        expected=watched * (0.0 if drop_out else detected),
        inside=seen.inside,
        skipped=seen.skipped,
        near=near_sector(sight, scan.sector, 2.0 * WAKE_MARGIN_M) if asleep.any() else seen.inside,
        new=loose,
    )


@dataclass(frozen=True, slots=True)
class _Shown:
    """Objects and their echoes, (k,) each."""

    objects: Indices
    echoes: Echoes
    evidence: Floats
    off_centre: Floats
    """Variance by which an echo may lie off its object's centre, m^2."""


def _parts(
    echoes: Echoes, explained: Mask, sight: Sight, radius: Floats, reported: Mask
) -> tuple[tuple[Indices, Indices], Indices]:
    """Return the echoes inside the circle of an object, as (objects, echoes), and the rest; those `explained` apart."""
    loose = ~explained
    wholes, parts = split_merged.parts_inside(sight, radius, echoes, reported.nonzero()[0], loose.nonzero()[0])
    loose[parts] = False
    return (wholes, parts), loose.nonzero()[0]


def _likely(
    parts: tuple[Indices, Indices],
    radius: Floats,
    clutter: ClutterDensity,
    visible: Floats,
    detection_probability: float,
) -> Candidates:
    """Return those `parts` (objects, echoes) that are not more likely false alarms inside a silent object's circle."""
    objects, echoes = parts
    if not len(echoes):
        return Candidates(objects, echoes, np.zeros(0))
    by_chance = np.minimum(clutter.per_m2[echoes] * np.pi * radius[objects] ** 2, 1.0)
    found = Candidates(objects, echoes, -np.log(by_chance))
    return found.take(gnn.worth_of(found, visible, detection_probability) > 0.0)


def _shown(echoes: Echoes, pairing: Pairing, parts: Candidates, radius: Floats) -> _Shown:
    """Return the pairs, and besides them the objects of which only `parts` are seen."""
    pairs = pairing.pairs
    if not len(parts.objects):
        return _Shown(pairs.objects, pairing.echoes, pairs.evidence, np.zeros(len(pairs.echoes)))
    in_parts = np.zeros(len(radius), bool)
    in_parts[parts.objects] = True
    smaller = echoes.radius[pairs.echoes] + 3.0 * echoes.sigma_radius[pairs.echoes] < radius[pairs.objects]
    also_part = in_parts[pairs.objects] & smaller
    whole = pairs.take(~also_part)
    in_parts[whole.objects] = False
    split = parts.take(in_parts[parts.objects])
    rest = split_merged.put_together(pairs.take(also_part).joined(split), echoes, radius)
    return _Shown(
        np.concatenate([whole.objects, rest.objects]),
        pairing.echoes.take((~also_part).nonzero()[0]).joined(rest.echoes),
        np.concatenate([whole.evidence, rest.evidence]),
        np.concatenate([np.zeros(len(whole.objects)), rest.variance]),
    )


def _is_drop_out(seen: View, reported: Mask, pairs: Candidates) -> bool:
    """Tell whether far fewer of the confirmed objects have an echo than are in view."""
    expected = float(seen.watched[reported].sum())
    found = int(np.count_nonzero(reported[pairs.objects] & (seen.watched[pairs.objects] > 0.0)))
    return expected >= DROP_OUT_EXPECTED and found <= DROP_OUT_SHARE * expected


@kernel
def _watched(seen: View, reported: Mask, hit: Mask, merged: Floats) -> Floats:
    """Return (n,) the `watched` of `Look`.

    `merged`: (n,) of `splits`: above 0, a missing echo may be in that of a neighbour.
    """
    watched = np.zeros(len(hit))
    for i in range(len(hit)):
        if hit[i] or merged[i] == 0.0:
            watched[i] = seen.watched[i] if reported[i] else 1.0 * (seen.inside[i] and not seen.skipped[i])
    return watched


def _fix(scan: Scan, vehicle: Vehicle, sight: Sight, shown: _Shown, off_centre: Floats) -> Fix:
    """Return the fixes of the objects seen; `off_centre`: (k,) variance by which an echo may lie off the centre."""
    half_vertical = scan.sector.half_vertical_rad
    lowest, highest = shown.echoes.elevation - half_vertical, shown.echoes.elevation + half_vertical
    elevation = np.minimum(np.maximum(sight.elevation[shown.objects], lowest), highest)
    fix = model.fix(shown.echoes, vehicle, half_vertical, elevation)
    if not off_centre.any():
        return fix
    return fix._replace(
        north=fix.north + off_centre,
        east=fix.east + off_centre,
        radius_variance=np.where(off_centre > 0.0, NO_RADIUS, fix.radius_variance),
    )
