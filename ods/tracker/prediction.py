"""What the image that comes should show of the objects: all that is computed of them before it is looked at, once."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.base.clock import NS
from ods.compiled.kernel import kernel
from ods.tracker.association.flicker import Places
from ods.tracker.measurement.field_of_view import (
    Coverage,
    FieldOfView,
    coverage_of,
    field_of_view,
    occluded,
    share_unseen,
    without_unseen,
)
from ods.tracker.measurement.model import PredictedMeasurement, predicted_measurement, predicted_rows
from ods.tracker.measurement.scan import Scan, Vehicle
from ods.tracker.named import Named
from ods.tracker.observer.belief import Belief, Estimate
from ods.tracker.settings import TrackerSettings
from ods.tracker.track import lifecycle
from ods.tracker.track.tracks import Tracks, history_rows

VAGUE_M = 1.0
"""A silent object whose place is less certain than this is vague."""
UNSEEN_S = 0.5
"""An object seen more recently than this is not silent; one behind another is then seen over it or beside it."""


class ScanPrediction(NamedTuple):
    """Of n objects."""

    vehicle: Vehicle
    fan: Coverage
    belief: Belief
    """Hypotheses of how each object moves, carried on to the ping,"""
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
    """(n,) those silent for so long that they take no single echo, which may be a false alarm: they are found again by
    a new object that is confirmed there."""

    @property
    def places(self) -> Places:
        """Where they are, in the fan and in the world."""
        predicted, position = self.measurement.rows, self.estimate.position
        return Places(predicted.range_m, predicted.bearing, position[0], position[1])


def predict_scan(tracks: Tracks, scan: Scan, vehicle: Vehicle, settings: TrackerSettings) -> ScanPrediction:
    """Return what `scan`, taken from `vehicle`, should show of `tracks`, which are carried on to it."""
    history, (belief, estimate) = tracks.history, tracks.told()
    by_hypothesis = predicted_measurement(
        belief.position, belief.variance, belief.covariance_ne, vehicle, belief.by_height
    )
    measurement = predicted_measurement(
        estimate.position, estimate.variance, estimate.covariance_ne, vehicle, estimate.by_height
    )
    fan = coverage_of(scan.sector, scan.fan_turn)
    radius = np.maximum(estimate.radius, 0.0)
    seen = field_of_view(measurement, radius, fan, scan.processed_ranges_m, settings.life.edge_sigmas)
    if len(scan.unseen):
        seen = without_unseen(seen, share_unseen(measurement, radius, fan, scan.unseen))
    reported = history.state != lifecycle.TENTATIVE
    silent, vague = _silent_and_vague(tracks.known[0], measurement.table, scan.t_ns)
    seen.watched[occluded(measurement, estimate.radius, silent, history.state == lifecycle.ACTIVE)] = 0.0
    return ScanPrediction(
        vehicle=vehicle,
        fan=fan,
        belief=belief,
        estimate=estimate,
        by_hypothesis=by_hypothesis,
        measurement=measurement,
        field_of_view=seen,
        visibility=tracks.visibility(settings.echo.return_rate) * seen.probability,
        reported=reported,
        vague=vague,
    )


@kernel
def _silent_and_vague(history_table: Ints, measurement_table: Floats, t_ns: int) -> Mask:
    """Return (2, n) the confirmed objects that are silent, and those of them whose place is vague."""
    history, measurement = history_rows(history_table), predicted_rows(measurement_table)
    found = np.empty((2, len(history.state)), np.bool_)
    silent, vague = found
    for i in range(len(silent)):
        silent[i] = history.state[i] != lifecycle.TENTATIVE and (t_ns - history.last[i]) / NS > UNSEEN_S
        vague[i] = silent[i] and max(measurement.along[i], measurement.across[i]) > VAGUE_M**2
    return found
