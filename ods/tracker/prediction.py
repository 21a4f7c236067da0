"""What the image that comes should show of the objects: all that is computed of them before it is looked at, once."""

from dataclasses import dataclass

from ods.base.arrays import Floats, Mask
from ods.base.clock import NS
from ods.tracker.measurement.field_of_view import Fan, FieldOfView, fan_of, field_of_view, hidden
from ods.tracker.measurement.model import PredictedMeasurement, predicted_measurement
from ods.tracker.measurement.scan import Scan, Vehicle
from ods.tracker.named import Named
from ods.tracker.observer.belief import Belief, Estimate
from ods.tracker.settings import TrackerSettings
from ods.tracker.track import existence, lifecycle
from ods.tracker.track.tracks import Tracks

SILENT_S = 0.5
"""An object seen more recently than this is not silent; one behind another is then seen over it or beside it."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """Of n objects."""

    vehicle: Vehicle
    fan: Fan
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
    silent: Mask
    """(n,) of these, those not seen lately."""


def predict(tracks: Tracks, scan: Scan, vehicle: Vehicle, settings: TrackerSettings) -> Prediction:
    """Return what `scan`, taken from `vehicle`, should show of `tracks`, which are carried on to it."""
    history, belief, estimate = tracks.history, tracks.belief(), tracks.estimate()
    by_hypothesis = predicted_measurement(belief.position, belief.variance, belief.covariance_ne, vehicle)
    measurement = predicted_measurement(estimate.position, estimate.variance, estimate.covariance_ne, vehicle)
    fan = fan_of(scan.sector, scan.fan_turn)
    seen = field_of_view(measurement, fan, scan.processed_ranges_m, settings.life.edge_sigmas)
    reported = history.state != lifecycle.TENTATIVE
    silent = reported & ((scan.t_ns - history.last) / NS > SILENT_S)
    seen.watched[silent & hidden(measurement, estimate.radius, history.state == lifecycle.ACTIVE)] = 0.0
    audible = existence.visibility(tracks.probabilities, tracks.unjudged_s, settings.echo)
    return Prediction(
        vehicle=vehicle,
        fan=fan,
        belief=belief,
        estimate=estimate,
        by_hypothesis=by_hypothesis,
        measurement=measurement,
        field_of_view=seen,
        visibility=audible * seen.probability,
        reported=reported,
        silent=silent,
    )
