"""Prediction of the next scan: all that is computed of the objects, once, before its echoes are used."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled import native
from ods.tracker.measurement.coverage.field_of_view import (
    Coverage,
    FieldOfView,
    coverage_of,
    exclude_not_swept,
    field_of_view,
    hidden_by,
)
from ods.tracker.measurement.model import PredictedMeasurement, predicted_measurements
from ods.tracker.measurement.scan import Scan, Vehicle
from ods.tracker.named import Named
from ods.tracker.observer.belief import Belief, Estimate
from ods.tracker.settings import TrackerSettings
from ods.tracker.track.tracks import Tracks


class ScanPrediction(NamedTuple):
    """Of n objects."""

    vehicle: Vehicle
    fan: Coverage
    belief: Belief
    """Hypotheses of how each object moves, predicted to the time of the ping,"""
    estimate: Estimate
    """and their moments."""
    by_hypothesis: Named[PredictedMeasurement]
    """(h, n) of the belief."""
    measurement: Named[PredictedMeasurement]
    """(n,) of the estimate."""
    field_of_view: FieldOfView
    """Objects that have been silent behind a nearer one are not watched."""
    visibility: Floats
    """(n,) probability that the object, if it exists, is in view and gives echoes at all just now."""
    reported: Mask
    """(n,) confirmed objects, hibernated ones too."""
    vague: Mask
    """(n,) objects silent for such a time that they take no single echo, which may be a false alarm: they are found
    again by a new object that is confirmed there."""


def predict_scan(tracks: Tracks, scan: Scan, vehicle: Vehicle, settings: TrackerSettings) -> ScanPrediction:
    """Return what `scan`, taken from `vehicle`, should show of `tracks`, which are predicted to its time."""
    (history, existence), (belief, estimate) = tracks.known, tracks.belief_and_moments()
    by_hypothesis, measurement = predicted_measurements(vehicle, belief[1:5], estimate[:4])
    fan, radius, ranges_m = coverage_of(scan.sector, scan.fan_turn), estimate.radius, scan.processed_ranges_m
    seen = field_of_view(measurement, radius, fan, ranges_m, settings.life.edge_sigmas, scan.unseen)
    if scan.looked is not None:
        seen = hidden_by(seen, scan.looked, measurement, radius)
    if len(scan.not_swept):
        exclude_not_swept(seen, measurement, scan.fan_turn, scan.not_swept)
    reported, vague = flags = np.empty((2, len(radius)), np.bool_)
    visibility, returned = np.empty(len(radius)), -math.expm1(-settings.echo.return_rate * tracks.unjudged_s)
    known = history, existence, measurement.table, radius, seen.probability
    native.judge_silent(known, scan.t_ns, returned, flags, seen.watched, visibility)
    return ScanPrediction(
        vehicle=vehicle,
        fan=fan,
        belief=belief,
        estimate=estimate,
        by_hypothesis=by_hypothesis,
        measurement=measurement,
        field_of_view=seen,
        visibility=visibility,
        reported=reported,
        vague=vague,
    )
