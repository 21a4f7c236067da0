"""What one image says about the objects: which echo is whose, who was missed, which echoes are of nobody."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.tracker import association, measurement
from ods.tracker.association import Candidates, ClutterDensity
from ods.tracker.belief import Belief, Estimate
from ods.tracker.life import State
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
    """(n,) it is in view or not far from it."""
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

    `state`: (n,) `life.State`.
    """
    sight = measurement.sight(estimate.position, estimate.variance, estimate.covariance_ne, vehicle)
    sights = measurement.sight(belief.position, belief.variance, belief.covariance_ne, vehicle)
    seen = view(sight, scan.sector, settings.life.edge_sigmas)
    reported = state != State.TENTATIVE
    miss = float(np.log1p(-settings.echo.detection_probability))
    found = association.candidates(sights, belief, scan.echoes, clutter, settings.echo)
    pairs = association.associate(found, reported, miss)
    loose = np.delete(np.arange(len(scan.echoes)), pairs.echoes)
    wholes, parts = association.fragments(sight, estimate.radius, scan.echoes, np.flatnonzero(reported), loose)
    extra = _first_part(wholes, parts, pairs.objects, estimate, clutter, settings.echo.detection_probability)

    objects, echoes = np.append(pairs.objects, extra.objects), np.append(pairs.echoes, extra.echoes)
    evidence = np.zeros(len(state))
    evidence[objects] = np.append(pairs.evidence, extra.evidence)
    hit = np.zeros(len(state), bool)
    hit[objects] = True
    merged = _merged(estimate, hit, reported & (seen.watched > 0.0))
    off_centre = merged[objects]
    off_centre[len(pairs.objects) :] += (PART_SHARE * estimate.radius[extra.objects]) ** 2
    drop_out = seen.watched[reported].sum() >= DROP_OUT_EXPECTED and not hit[reported].any()
    watched = np.where(hit | (merged == 0.0), seen.watched, 0.0)
    return Look(
        objects=objects,
        fix=_fix(scan, vehicle, sight, objects, echoes, off_centre),
        hit=hit,
        evidence=evidence,
        watched=watched,
        expected=watched * (0.0 if drop_out else settings.echo.detection_probability),
        inside=seen.inside,
        near=near_sector(sight, scan.sector, 2.0 * WAKE_MARGIN_M),
        new=np.setdiff1d(loose, parts),
    )


def _first_part(
    wholes: Rows, parts: Rows, seen: Rows, estimate: Estimate, clutter: ClutterDensity, detection_probability: float
) -> Candidates:
    """Of the objects that no echo fits, but that have echoes inside their circle, return each with one such echo."""
    fresh = ~np.isin(wholes, seen)
    objects, first = np.unique(wholes[fresh], return_index=True)
    echoes = parts[fresh][first]
    by_chance = np.minimum(clutter.per_m2[echoes] * np.pi * estimate.radius[objects] ** 2, 1.0)
    return Candidates(objects, echoes, np.log(detection_probability / by_chance))


def _merged(estimate: Estimate, hit: Mask, here: Mask) -> Array:
    """Return (n,) variance, m^2, by which an echo may lie off its object's centre because it is of two objects.

    Where the circles of two objects touch and only one of them is seen, its echo may be the echo of both. 0: no such
    neighbour.
    """
    result = np.zeros(len(hit))
    seen, unseen = np.flatnonzero(here & hit), np.flatnonzero(here & ~hit)
    if not len(seen) or not len(unseen):
        return result
    offset = estimate.position[:2, seen][:, :, None] - estimate.position[:2, unseen][:, None, :]
    separation = np.hypot(offset[0], offset[1])
    touching = separation < estimate.radius[seen][:, None] + estimate.radius[unseen]
    half = np.where(touching, np.maximum(0.5 * separation, SMALLEST_OFFSET_M), 0.0) ** 2
    result[seen], result[unseen] = half.max(axis=1), half.max(axis=0)
    return result


def _fix(scan: Scan, vehicle: Vehicle, sight: Sight, objects: Rows, echoes: Rows, off_centre: Array) -> Fix:
    """Return the fixes of pairs; `off_centre`: (k,) variance by which an echo may lie off its object's centre."""
    taken = scan.echoes.take(echoes)
    half_vertical = scan.sector.half_vertical_rad
    elevation = np.clip(sight.elevation[objects], taken.elevation - half_vertical, taken.elevation + half_vertical)
    fix = measurement.fix(taken, vehicle, half_vertical, elevation)
    if not off_centre.any():
        return fix
    return replace(
        fix,
        north=fix.north + off_centre,
        east=fix.east + off_centre,
        radius_variance=np.where(off_centre > 0.0, NO_RADIUS, fix.radius_variance),
    )
