"""What one image says about the objects: which echo is whose, who was missed, which echoes are of nobody."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled.kernel import kernel
from ods.messages import Sector
from ods.tracker.association import gating, split_merged
from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.clutter import Clutter, ClutterDensity
from ods.tracker.association.flicker import Flicker, Places
from ods.tracker.association.gating import Detectability, Hypotheses
from ods.tracker.association.registry import Association
from ods.tracker.association.strength import Strength, Typical
from ods.tracker.association.wander import Wander
from ods.tracker.measurement.field_of_view import FieldOfView
from ods.tracker.measurement.model import PositionMeasurement, position_measurement
from ods.tracker.measurement.scan import Echoes, Scan
from ods.tracker.prediction import ScanPrediction
from ods.tracker.settings import EchoSettings
from ods.tracker.track.tracks import Unexplained

DROP_OUT_EXPECTED = 3.0
"""So many confirmed objects expected,"""
DROP_OUT_SHARE = 0.25
"""and no more than this share of them seen: a drop-out of the image, which counts against nobody,"""
DROP_OUT_DETECTION = 0.005
"""and in which an object has an echo with this probability: what is found is more likely a false alarm."""
NO_RADIUS = 1e6
"""Variance of a radius that was not measured, m^2."""


class FalseAlarms(NamedTuple):
    """What is known of echoes that are no object's."""

    clutter: Clutter
    flicker: Flicker
    strength: Strength
    wander: Wander


class ScanMatch(NamedTuple):
    """n objects, of which k were seen."""

    objects: Indices
    """(k,) the objects seen, each once,"""
    measurement: PositionMeasurement
    """and where (k,)."""
    hit: Mask
    """(n,) seen."""
    llr: Floats
    """(n,) log-likelihood ratio of the echo: of the object, or a false alarm; 0 where not hit."""
    watched: Floats
    """(n,) probability that the sonar looked at the object,"""
    expected: Floats
    """and that a visible object would have given an echo; 0 in a drop-out."""
    spots: Floats
    """(n,) share of spots, which come and go, among echoes of nothing at each: see `flicker`."""
    strength: Floats
    """(n,) of the echo, dB; 0: none, or not told."""
    typical: Typical
    """Of n echoes of nothing, where the objects are."""
    off_range: Floats
    """(n,) by how much the echo is farther than the object was expected, m; NaN: none, or one that is not all of it
    and only of it."""
    unexplained: PositionMeasurement | None
    """Where echoes come from that no object explains, k; None: there are none,"""
    unknown: Unexplained
    """and what is known of them."""


def match_scan(
    scan: Scan, prediction: ScanPrediction, alarms: FalseAlarms, associate: Association, settings: EchoSettings
) -> ScanMatch:
    """Compare an image with what was predicted of n objects; `alarms` learn from the echoes that none explains."""
    clutter, echoes = alarms.clutter, scan.echoes
    density = clutter.density(echoes, scan.sector)
    chance = Detectability(prediction.visibility, settings.detection_probability)
    moving, belief = prediction.by_hypothesis, prediction.belief
    found = gating.hypotheses(moving, belief, echoes, density, chance, settings.gate_sigmas)
    found = found.take(~prediction.vague[found.objects])
    ask = Question(found, prediction.reported, echoes, prediction.measurement, prediction.estimate)
    assignment = associate(ask)
    drop_out = _is_drop_out(prediction, assignment.pairs)
    if drop_out:
        chance = chance._replace(detection_probability=DROP_OUT_DETECTION)
        less = math.log(DROP_OUT_DETECTION / settings.detection_probability)
        found = gating.scored(found.objects, found.echoes, found.llr + less, chance)
        assignment = associate(ask._replace(hypotheses=found))
    shown, unexplained = _with_parts(assignment, echoes, prediction, density, chance)
    hit = np.zeros(len(prediction.reported), bool)
    hit[shown.objects] = True
    seen, reported = prediction.field_of_view, prediction.reported
    merged = split_merged.merged_variance(prediction.estimate, hit, reported & (seen.watched > 0.0))
    watched = _watched(seen, reported, hit, merged)
    rest, half_vertical = echoes.take(unexplained), scan.sector.half_vertical_rad
    measurement = _measured(shown, merged, prediction, half_vertical)
    elsewhere = position_measurement(rest, prediction.vehicle, half_vertical) if len(rest) else None
    strength = np.zeros(len(hit))
    strength[shown.objects] = shown.echoes.rows.strength
    alarms.strength.count(_not_of_confirmed(echoes, assignment.pairs, reported), scan.sector)
    spots = alarms.flicker.share(prediction.places, scan.sector, alarms.strength.per_scan)
    typical = alarms.strength.typical(prediction.measurement.rows.range_m, scan.sector)
    if len(hit):
        clutter.count(rest, scan.sector, scan.processed_ranges_m)
    return ScanMatch(
        objects=shown.objects,
        measurement=measurement,
        hit=hit,
        llr=np.asarray(np.bincount(shown.objects, shown.llr, len(hit)), np.float64),
        watched=watched,
        expected=watched * (0.0 if drop_out else chance.detection_probability),
        spots=spots,
        strength=strength,
        typical=typical,
        off_range=_off_range(shown, merged, prediction),
        unexplained=elsewhere,
        unknown=_unknown(rest, elsewhere, alarms, scan.sector),
    )


def _off_range(shown: "_Shown", merged: Floats, prediction: ScanPrediction) -> Floats:
    """Return the `off_range` of `ScanMatch`; `merged` as in `_measured`."""
    off = np.full(len(merged), np.nan)
    off[shown.objects] = shown.echoes.rows.range_m - prediction.measurement.rows.range_m[shown.objects]
    off[shown.objects[shown.off_centre > 0.0]] = np.nan
    off[merged > 0.0] = np.nan
    return off


def _not_of_confirmed(echoes: Echoes, pairs: Hypotheses, reported: Mask) -> Echoes:
    """Return the echoes that no confirmed object explains."""
    free = np.ones(len(echoes), bool)
    free[pairs.echoes[reported[pairs.objects]]] = False
    return echoes.take(free.nonzero()[0])


def _unknown(rest: Echoes, places: PositionMeasurement | None, alarms: FalseAlarms, sector: Sector) -> Unexplained:
    """Return what is known of the echoes `rest`, which no object explains and which come from `places`."""
    clutter, nowhere = alarms.clutter, np.zeros(0)
    north, east = (nowhere, nowhere) if places is None else places.position[:2]
    where = Places(rest.rows.range_m, rest.rows.bearing, north, east)
    return Unexplained(
        clutter.density(rest, sector).per_scan,
        alarms.flicker.share(where, sector, alarms.strength.per_scan),
        rest.rows.strength,
        alarms.strength.typical(rest.rows.range_m, sector),
    )


def _is_drop_out(prediction: ScanPrediction, pairs: Hypotheses) -> bool:
    """Tell whether far fewer of the confirmed objects have an echo than are in view."""
    watched = prediction.field_of_view.watched * prediction.reported
    expected = float(watched.sum())
    found = int(np.count_nonzero(watched[pairs.objects]))
    return expected >= DROP_OUT_EXPECTED and found <= DROP_OUT_SHARE * expected


class _Shown(NamedTuple):
    """Objects and their echoes, (k,) each."""

    objects: Indices
    echoes: Echoes
    llr: Floats
    off_centre: Floats
    """Variance by which an echo may lie off its object's centre, m^2."""


def _with_parts(
    assignment: Assignment, echoes: Echoes, prediction: ScanPrediction, density: ClutterDensity, chance: Detectability
) -> tuple[_Shown, Indices]:
    """Return the objects seen, as a whole or only in parts, and the echoes that nobody explains."""
    radius, loose = prediction.estimate.radius, ~assignment.explained
    objects, parts = split_merged.parts_inside(
        prediction.measurement, radius, echoes, prediction.reported.nonzero()[0], loose.nonzero()[0]
    )
    loose[parts] = False
    pairs, unexplained = assignment.pairs, loose.nonzero()[0]
    if len(parts):
        by_chance = np.minimum(density.per_m2[parts] * np.pi * radius[objects] ** 2, 1.0)
        split = gating.scored(objects, parts, -np.log(by_chance), chance)
        split = split.take(split.score > 0.0)  # the rest is more likely false alarms inside a silent object's circle
        if len(split.objects):
            return _put_together(assignment, split, echoes, radius), unexplained
    return _Shown(pairs.objects, assignment.echoes, pairs.llr, np.zeros(len(pairs.objects))), unexplained


def _put_together(assignment: Assignment, split: Hypotheses, echoes: Echoes, radius: Floats) -> _Shown:
    """Return the pairs, and besides them the objects of which only the parts `split` are seen."""
    pairs = assignment.pairs
    in_parts = np.zeros(len(radius), bool)
    in_parts[split.objects] = True
    smaller = echoes.rows.radius[pairs.echoes] + 3.0 * echoes.rows.sigma_radius[pairs.echoes] < radius[pairs.objects]
    also_part = in_parts[pairs.objects] & smaller
    whole = pairs.take(~also_part)
    in_parts[whole.objects] = False
    split = split.take(in_parts[split.objects])
    parts = split_merged.put_together(pairs.take(also_part).joined(split), echoes, radius)
    return _Shown(
        np.concatenate([whole.objects, parts.objects]),
        assignment.echoes.take((~also_part).nonzero()[0]).joined(parts.echoes),
        np.concatenate([whole.llr, parts.llr]),
        np.concatenate([np.zeros(len(whole.objects)), parts.variance]),
    )


@kernel
def _watched(seen: FieldOfView, reported: Mask, hit: Mask, merged: Floats) -> Floats:
    """Return (n,) the `watched` of `ScanMatch`.

    `merged`: (n,) of `merged_variance`: above 0, a missing echo may be in that of a neighbour.
    """
    watched = np.zeros(len(hit))
    for i in range(len(hit)):
        if hit[i] or merged[i] == 0.0:
            watched[i] = seen.watched[i] if reported[i] else 1.0 * (seen.inside[i] and not seen.skipped[i])
    return watched


def _measured(shown: _Shown, merged: Floats, prediction: ScanPrediction, half_vertical: float) -> PositionMeasurement:
    """Return where the objects were seen; `merged`: (n,) variance by which an echo may lie off the centre."""
    predicted = prediction.measurement.table.take(shown.objects, axis=1)
    found = position_measurement(shown.echoes, prediction.vehicle, half_vertical, predicted)
    off_centre = shown.off_centre + merged[shown.objects]
    if not off_centre.any():
        return found
    return found._replace(
        variance_north=found.variance_north + off_centre,
        variance_east=found.variance_east + off_centre,
        radius_variance=np.where(off_centre > 0.0, NO_RADIUS, found.radius_variance),
    )
