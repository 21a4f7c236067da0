"""What one image says about the objects: which echo is whose, who was missed, which echoes are of nobody."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.tracker import association, life, measurement
from ods.tracker.association import Candidates, ClutterDensity
from ods.tracker.belief import Belief, Estimate
from ods.tracker.measurement import Fix, Sight
from ods.tracker.scan import Scan, Vehicle
from ods.tracker.settings import TrackerSettings
from ods.tracker.view import near_sector, view

Rows = NDArray[np.intp]
Mask = NDArray[np.bool_]

DROP_OUT_EXPECTED = 3
"""So many confirmed objects expected and none seen: a drop-out of the image, which counts against nobody."""
PART_SHARE = 0.5
"""A part of a large object lies off its centre by about this share of its radius: standard deviation."""
SMALLEST_OFFSET_M = 1e-3
"""The echo of two objects at one place is off the centre of each by at least this."""
WAKE_MARGIN_M = 5.0
"""Hibernated objects join the live ones so near to the sector's edge, and sleep again at twice that distance."""
NO_RADIUS = 1e6
"""Variance of a radius that was not measured, m^2."""


@dataclass(frozen=True, slots=True)
class Look:
    """n objects, of which k were seen."""

    objects: Rows
    """(k,) the objects seen, each once,"""
    fix: Fix
    """and where (k,)."""
    hit: Mask
    """(n,) seen."""
    watched: Array
    """(n,) probability that the sonar looked at the object,"""
    expected: Array
    """and that a visible object would have given an echo; 0 in a drop-out."""
    evidence: Array
    """(n,) log-likelihood ratio of the echo: object against false alarm; 0 where not hit."""
    inside: Mask
    """(n,) the predicted place is in the sonar's view."""
    near: Mask
    """(n,) it is in view or, for hibernated objects, not far from it."""
    new: Rows
    """Echoes that no object explains."""


def look(
    scan: Scan,
    vehicle: Vehicle,
    belief: Belief,
    estimate: Estimate,
    state: NDArray[np.int64],
    clutter: ClutterDensity,
    settings: TrackerSettings,
) -> Look:
    """Compare an image with the predictions of n objects: their hypotheses `belief`, and `estimate`, the mixture.

    `state`: (n,) a state of `life`.
    """
    sights = _sights(belief, estimate, vehicle)
    sight = sights.take(-1)
    seen = view(sight, scan.sector, settings.life.edge_sigmas)
    reported = state != life.TENTATIVE
    miss = float(np.log1p(-settings.echo.detection_probability))
    found = association.candidates(sights.take(slice(-1)), belief, scan.echoes, clutter, settings.echo)
    pairs = association.associate(found, reported, len(scan.echoes), miss)
    hit = np.zeros(len(state), bool)
    hit[pairs.objects] = True
    loose = np.ones(len(scan.echoes), bool)
    loose[pairs.echoes] = False
    wholes, parts = association.fragments(
        sight, estimate.radius, scan.echoes, reported.nonzero()[0], loose.nonzero()[0]
    )
    loose[parts] = False
    whole = len(pairs.objects)
    if len(parts):
        pairs = _with_parts(pairs, wholes, parts, hit, estimate, clutter, settings.echo.detection_probability)
        hit[pairs.objects] = True

    evidence = np.zeros(len(state))
    evidence[pairs.objects] = pairs.evidence
    merged = _merged(estimate, hit, reported & (seen.watched > 0.0))
    off_centre = merged[pairs.objects]
    off_centre[whole:] += (PART_SHARE * estimate.radius[pairs.objects[whole:]]) ** 2
    watched = np.where(hit | (merged == 0.0), seen.watched, 0.0)
    drop_out = seen.watched[reported].sum() >= DROP_OUT_EXPECTED and not hit[reported].any()
    asleep = state == life.HIBERNATED
    return Look(
        objects=pairs.objects,
        fix=_fix(scan, vehicle, sight, pairs, off_centre),
        hit=hit,
        evidence=evidence,
        watched=watched,
        expected=watched * (0.0 if drop_out else settings.echo.detection_probability),
        inside=seen.inside,
        near=near_sector(sight, scan.sector, 2.0 * WAKE_MARGIN_M) if asleep.any() else seen.inside,
        new=loose.nonzero()[0],
    )


def _sights(belief: Belief, estimate: Estimate, vehicle: Vehicle) -> Sight:
    """Return what the sonar should see, (h + 1, n): by each hypothesis, and last by the mixture."""
    return measurement.sight(
        np.concatenate([belief.position, estimate.position[:, None]], axis=1),
        np.concatenate([belief.variance, estimate.variance[:, None]], axis=1),
        np.concatenate([belief.covariance_ne, estimate.covariance_ne[None]]),
        vehicle,
    )


def _with_parts(
    pairs: Candidates,
    wholes: Rows,
    parts: Rows,
    hit: Mask,
    estimate: Estimate,
    clutter: ClutterDensity,
    detection_probability: float,
) -> Candidates:
    """Add one pair for each object that no echo fits, but that has echoes (`parts`) inside its circle."""
    unseen = ~hit[wholes]
    objects, first = np.unique(wholes[unseen], return_index=True)
    echoes = parts[unseen][first]
    by_chance = np.minimum(clutter.per_m2[echoes] * np.pi * estimate.radius[objects] ** 2, 1.0)
    return Candidates(
        np.concatenate([pairs.objects, objects]),
        np.concatenate([pairs.echoes, echoes]),
        np.concatenate([pairs.evidence, np.log(detection_probability / by_chance)]),
    )


def _merged(estimate: Estimate, hit: Mask, here: Mask) -> Array:
    """Return (n,) variance, m^2, by which an echo may lie off its object's centre because it is of two objects.

    Where the circles of two objects touch and only one of them is seen, its echo may be the echo of both. 0: no such
    neighbour.
    """
    result = np.zeros(len(hit))
    seen, unseen = (here & hit).nonzero()[0], (here & ~hit).nonzero()[0]
    if not len(seen) or not len(unseen):
        return result
    offset = estimate.position[:2, seen][:, :, None] - estimate.position[:2, unseen][:, None, :]
    separation = np.hypot(offset[0], offset[1])
    touching = separation < estimate.radius[seen][:, None] + estimate.radius[unseen]
    half = np.where(touching, np.maximum(0.5 * separation, SMALLEST_OFFSET_M), 0.0) ** 2
    result[seen], result[unseen] = half.max(axis=1), half.max(axis=0)
    return result


def _fix(scan: Scan, vehicle: Vehicle, sight: Sight, pairs: Candidates, off_centre: Array) -> Fix:
    """Return the fixes of pairs; `off_centre`: (k,) variance by which an echo may lie off its object's centre."""
    taken = scan.echoes.take(pairs.echoes)
    half_vertical = scan.sector.half_vertical_rad
    lowest, highest = taken.elevation - half_vertical, taken.elevation + half_vertical
    elevation = np.minimum(np.maximum(sight.elevation[pairs.objects], lowest), highest)
    fix = measurement.fix(taken, vehicle, half_vertical, elevation)
    if not off_centre.any():
        return fix
    return replace(
        fix,
        north=fix.north + off_centre,
        east=fix.east + off_centre,
        radius_variance=np.where(off_centre > 0.0, NO_RADIUS, fix.radius_variance),
    )
