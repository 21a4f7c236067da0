"""Matches the echoes of one image with the objects: associated echoes, missed objects, clutter."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled import native
from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.hypotheses import gating
from ods.tracker.association.hypotheses.clutter import Clutter, ClutterDensity
from ods.tracker.association.hypotheses.gating import Detectability
from ods.tracker.association.registry import Association
from ods.tracker.existence.evidence import ScanEvidence
from ods.tracker.measurement.coverage.cut_off import NOT_MEASURED, limit_information
from ods.tracker.measurement.coverage.field_of_view import FieldOfView
from ods.tracker.measurement.model import PositionMeasurement, position_measurement
from ods.tracker.measurement.scan import Echoes, Scan
from ods.tracker.named import Named
from ods.tracker.prediction import ScanPrediction
from ods.tracker.settings import EchoSettings


class ScanMatch(NamedTuple):
    """n objects, of which k were seen."""

    objects: Indices
    """(k,) the objects seen, each once,"""
    measurement: PositionMeasurement
    """Where they were seen, (k,)."""
    hit: Mask
    """(n,) seen."""
    evidence: Named[ScanEvidence]
    """What the image shows of each."""
    unexplained: PositionMeasurement | None
    """Measurement of the k echoes that no object explains; None if there are none."""
    rest: Echoes
    """The k echoes that no object explains."""
    density: Floats
    """(k,) clutter density at each unexplained echo, as false alarms per scan over the whole fan."""
    free: Mask
    """(m,) echoes that no confirmed object explains."""


class ExplainedEchoes(NamedTuple):
    """What an image of m echoes shows of n objects: k of them are seen, as a whole or only in parts."""

    objects: Indices
    """(k,) each once,"""
    echoes: Echoes
    """and the echo of each, (k,): its own, or what stands for several."""
    off_centre: Floats
    """(k,) variance by which the echo may lie off the object's centre, m^2."""
    unexplained: Indices
    """Echoes that no object explains."""
    hit: Mask
    """(n,) seen."""
    evidence: Named[ScanEvidence]
    free: Mask
    """(m,) echoes that no confirmed object explains."""


def match_scan(
    scan: Scan, prediction: ScanPrediction, clutter: Clutter, associate: Association, settings: EchoSettings
) -> ScanMatch:
    """Compare an image with what was predicted of n objects; `clutter` learns from the echoes that none explains."""
    echoes, view = scan.echoes, prediction.field_of_view
    density = clutter.density(echoes, scan.sector)
    chance = Detectability(prediction.visibility, settings.detection_probability)
    moving, belief = prediction.by_hypothesis, prediction.belief
    found = gating.hypotheses(moving, belief, echoes, density, chance, settings.gate_sigmas, prediction.vague)
    ask = Question(found, prediction.reported, echoes, prediction.measurement, prediction.estimate)
    seen = shown(ask, associate(ask), view, density, chance)
    rest, half_vertical = echoes.take(seen.unexplained), scan.sector.half_vertical_rad
    measurement = _measured(seen, prediction, half_vertical)
    elsewhere = position_measurement(rest, prediction.vehicle, half_vertical) if seen.unexplained.size else None
    if len(seen.hit):
        clutter.count(rest, scan.sector, scan.processed_ranges_m)
    return ScanMatch(
        objects=seen.objects,
        measurement=measurement,
        hit=seen.hit,
        evidence=seen.evidence,
        unexplained=elsewhere,
        rest=rest,
        density=density.per_scan.take(seen.unexplained),
        free=seen.free,
    )


def shown(
    question: Question, assignment: Assignment, view: FieldOfView, density: ClutterDensity, chance: Detectability
) -> ExplainedEchoes:
    """Return what is seen of the objects. Raises IndexError.

    Echoes that are left and lie inside the circle of a confirmed object are parts of it. Their middle is what such an
    object is seen by, unless it has an echo of its own that is as large as it is.
    """
    pairs, n, m = assignment.pairs, len(question.first), len(assignment.explained)
    room = len(pairs.objects) + m
    objects, table = np.empty(room, np.intp), np.empty((len(question.echoes.table), room))
    llr, off_centre = np.empty((2, room))
    unexplained, hit, free = np.empty(m, np.intp), np.empty(n, np.bool_), np.empty(m, np.bool_)
    evidence, counts = np.empty((len(ScanEvidence._fields), n)), np.empty(2, np.intp)
    asked = assignment.echoes.table, assignment.explained, question.echoes.table, density.per_m2
    expected = question.predicted.table, question.estimate.position, question.estimate.radius, question.first
    seen = chance.visibility, view.watched, view.inside, view.skipped
    answer = objects, table, llr, off_centre, unexplained, hit, evidence, free, counts
    if not native.match_shown(pairs, asked, expected, seen, chance.detection_probability, answer):
        raise IndexError("an association's pair has an index beyond the objects or echoes")
    k, left = counts.tolist()
    echoes = Echoes(table.ravel()[: len(table) * k].reshape(len(table), k))
    return ExplainedEchoes(
        objects[:k], echoes, off_centre[:k], unexplained[:left], hit, Named(ScanEvidence, evidence), free
    )


def _measured(shown: ExplainedEchoes, prediction: ScanPrediction, half_vertical: float) -> PositionMeasurement:
    """Return where the objects were seen."""
    predicted = prediction.measurement.table.take(shown.objects, axis=1)
    echoes, seen, estimate = shown.echoes, shown.objects, prediction.estimate
    if echoes.rows.cut.any():
        echoes = limit_information(echoes, predicted, estimate.radius[seen], estimate.radius_variance[seen])
    found = position_measurement(echoes, prediction.vehicle, half_vertical, predicted)
    off_centre = shown.off_centre
    if not off_centre.any():
        return found
    return found._replace(
        variance_north=found.variance_north + off_centre,
        variance_east=found.variance_east + off_centre,
        radius_variance=np.where(
            off_centre > 0.0, np.maximum(NOT_MEASURED, found.radius_variance), found.radius_variance
        ),
    )
