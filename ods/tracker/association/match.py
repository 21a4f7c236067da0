"""What one image says about the objects: which echo is whose, who was missed, which echoes are of nobody."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled import native
from ods.messages import Sector
from ods.tracker.association import gating, split_merged
from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.clutter import Clutter, ClutterDensity
from ods.tracker.association.crowd import crowding
from ods.tracker.association.flicker import Flicker, Places
from ods.tracker.association.front import Front
from ods.tracker.association.gating import Detectability, Hypotheses
from ods.tracker.association.onset import Onset
from ods.tracker.association.registry import Association
from ods.tracker.association.strength import Strength
from ods.tracker.association.wander import Wander
from ods.tracker.measurement.cut_off import nothing_twice
from ods.tracker.measurement.model import PositionMeasurement, position_measurement
from ods.tracker.measurement.scan import Echoes, Scan
from ods.tracker.named import Named
from ods.tracker.prediction import ScanPrediction
from ods.tracker.settings import EchoSettings
from ods.tracker.track.doubt import AtPlaces, Look, Spots, Unexplained

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
    onset: Onset
    front: Front

    def spots(self, dt: float) -> Spots:
        """Return what is known of the echoes of spots; `dt`: from the image before to the newest, s."""
        crowd = crowding(self.strength.per_scan, dt)
        return Spots(self.wander.of_spots_m2, self.onset.of_spots, self.front.of_spots, crowd)

    def at(self, places: Places, sector: Sector) -> AtPlaces:
        """Return what echoes of nothing are like at n places."""
        spots = self.flicker.share(places, sector, self.strength.per_scan)
        return AtPlaces(spots, self.strength.typical(places.range_m, sector).table)


class ScanMatch(NamedTuple):
    """n objects, of which k were seen."""

    objects: Indices
    """(k,) the objects seen, each once,"""
    measurement: PositionMeasurement
    """and where (k,)."""
    hit: Mask
    """(n,) seen."""
    look: Named[Look]
    """What the image shows of each."""
    nothing: AtPlaces
    """What echoes of nothing are like where the objects are."""
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
    found = gating.hypotheses(moving, belief, echoes, density, chance, settings.gate_sigmas, prediction.vague)
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
    merged = split_merged.merged_variance(prediction.estimate, hit, reported, seen.watched)
    rest, half_vertical = echoes.take(unexplained), scan.sector.half_vertical_rad
    measurement = _measured(shown, merged, prediction, half_vertical)
    elsewhere = position_measurement(rest, prediction.vehicle, half_vertical) if len(rest) else None
    told = shown.objects, shown.echoes.table, shown.llr, shown.off_centre
    watched = seen.watched, reported, hit, seen.inside & ~seen.skipped
    expected = prediction.measurement.table, prediction.estimate.radius
    look = np.empty((len(Look._fields), len(hit)))
    native.match_look(told, merged, watched, expected, 0.0 if drop_out else chance.detection_probability, look)
    free = np.empty(len(echoes), np.bool_)
    native.match_not_of_confirmed(assignment.pairs.objects, assignment.pairs.echoes, reported, free)
    alarms.strength.count(echoes, free, scan.sector)
    nothing = alarms.at(prediction.places, scan.sector)
    if len(hit):
        clutter.count(rest, scan.sector, scan.processed_ranges_m)
    return ScanMatch(
        objects=shown.objects,
        measurement=measurement,
        hit=hit,
        look=Named(Look, look),
        nothing=nothing,
        unexplained=elsewhere,
        unknown=_unknown(rest, elsewhere, alarms, scan.sector),
    )


def _unknown(rest: Echoes, places: PositionMeasurement | None, alarms: FalseAlarms, sector: Sector) -> Unexplained:
    """Return what is known of the echoes `rest`, which no object explains and which come from `places`."""
    clutter, nowhere = alarms.clutter, np.zeros(0)
    north, east = (nowhere, nowhere) if places is None else places.position[:2]
    where = Places(rest.rows.range_m, rest.rows.bearing, north, east)
    density, nothing = clutter.density(rest, sector).per_scan, alarms.at(where, sector)
    told = rest.rows.strength, rest.rows.onset, rest.rows.front
    return Unexplained(density, *told, nothing, alarms.onset.of_spots, alarms.front.of_spots)


def _is_drop_out(prediction: ScanPrediction, pairs: Hypotheses) -> bool:
    """Tell whether far fewer of the confirmed objects have an echo than are in view."""
    watched = prediction.field_of_view.watched * prediction.reported
    expected = float(watched.sum())
    if expected < DROP_OUT_EXPECTED:
        return False
    return int(np.count_nonzero(watched.take(pairs.objects))) <= DROP_OUT_SHARE * expected


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
    pairs, radius, loose = assignment.pairs, prediction.estimate.radius, ~assignment.explained
    whole, unexplained = prediction.reported.nonzero()[0], loose.nonzero()[0]
    objects, parts = split_merged.parts_inside(prediction.measurement, radius, echoes, whole, unexplained)
    if len(parts):
        loose[parts] = False
        unexplained = loose.nonzero()[0]
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


def _measured(shown: _Shown, merged: Floats, prediction: ScanPrediction, half_vertical: float) -> PositionMeasurement:
    """Return where the objects were seen; `merged`: (n,) variance by which an echo may lie off the centre."""
    predicted = prediction.measurement.table.take(shown.objects, axis=1)
    echoes, seen, estimate = shown.echoes, shown.objects, prediction.estimate
    if echoes.rows.cut.any():
        echoes = nothing_twice(echoes, predicted, estimate.radius[seen], estimate.radius_variance[seen])
    found = position_measurement(echoes, prediction.vehicle, half_vertical, predicted)
    off_centre = shown.off_centre + merged[shown.objects]
    if not off_centre.any():
        return found
    return found._replace(
        variance_north=found.variance_north + off_centre,
        variance_east=found.variance_east + off_centre,
        radius_variance=np.where(off_centre > 0.0, NO_RADIUS, found.radius_variance),
    )
