"""Between the sonar's polar measurements and the global frame: eq. 1 with the pose at the ping, and its covariance."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.tracker.measurement.scan import NO_NOISE, Echoes, Vehicle
from ods.tracker.named import Named

UNSEEN = 4
HEIGHT, BEND, ATTITUDE, CLIMB = range(UNSEEN)
"""What the ping does not see, but the horizontal place depends on: the height, its square, the bias of the attitude,
and by which earlier pings were reported, how much the height changes."""


class PredictedMeasurement(NamedTuple):
    """Where the sonar should see objects: arrays of one shape, such as (n,) or (hypotheses, n)."""

    range_m: Floats
    """Slant range."""
    bearing: Floats
    elevation: Floats
    """In the body frame, up positive."""
    horizontal: Floats
    """Horizontal distance, m."""
    along: Floats
    """Variance of the predicted position along the line of sight, pose included, m^2;"""
    across: Floats
    """across it;"""
    mixed: Floats
    """and the covariance of both."""
    vertical: Floats
    """Variance of the predicted height above the fan's plane, m^2."""


PREDICTED = len(PredictedMeasurement._fields)


class PositionMeasurement(NamedTuple):
    """Echoes converted to positions in the global frame, with their noise: (k,) arrays.

    At `height` + h the horizontal place is `position` + `sensitivity[HEIGHT]` h + `sensitivity[BEND]` h^2.
    """

    position: Floats
    """(3, k) NED; down is the fan's middle there."""
    variance_north: Floats
    """m^2."""
    variance_east: Floats
    """m^2."""
    covariance_ne: Floats
    """Of north and east, m^2."""
    half_height: Floats
    """The object is within this of `position[2]`, m."""
    radius: Floats
    radius_variance: Floats
    height: Floats
    """Down: the height that `position[:2]` is the place of."""
    azimuth: Floats
    """(2, k) by how much the line of sight turns, rad, for each metre that the object is farther north and east."""
    sensitivity: Floats
    """(UNSEEN, 2, k) change of north and east: per m of height, per m^2, by a standard deviation of the attitude, m,
    and by one of the climb, m: 0, as the height is that at the ping."""
    pose_variance: Floats
    """(2,) of the bias of the vehicle's own north and east, m^2."""
    tilt_variance: Floats = NO_NOISE[:1]
    """(1,) of the noise of its tilt, rad^2: `sensitivity[HEIGHT]` has it, too."""


def predicted_measurements(
    vehicle: Vehicle, *believed: tuple[Floats, Floats, Floats, Floats]
) -> list[Named[PredictedMeasurement]]:
    """Predict what the sonar measures of objects: eq. 1 solved for the body frame, and the covariance.

    Each of `believed`, by h hypotheses of n objects: (h, 3, n) positions, NED; (h, 3, n) variances, of north and east
    at a given height, and of the height; (h, n) covariances of north and east at a given height; (h, 2, n) by how much
    north and east are larger for each metre that the object is lower. Without their first axis: of one hypothesis.
    """
    made = [np.empty((PREDICTED, *covariance_ne.shape)) for _, _, covariance_ne, _ in believed]
    for known, table in zip(believed, made, strict=True):
        (native.predict_objects if table.ndim == 2 else native.predict_hypotheses)(*known, vehicle, table)
    return [Named(PredictedMeasurement, table) for table in made]


def position_measurement(
    echoes: Echoes, vehicle: Vehicle, half_vertical: float, predicted: Floats | None = None
) -> PositionMeasurement:
    """Return eq. 1, z_og = z_ag + R^-1 z_ob, for all echoes, with measurement noise that includes the pose's.

    `predicted`: (8, m), the table of `PredictedMeasurement`, of the objects already tracked that the echoes are of;
    None: they are of new ones. Range and bearing of a known one are taken in where it should be, along the tangent
    there: across wide beams the noise would bend the ellipse, and turn it with each echo. A new object is where its
    echo is, in the fan's middle. `half_vertical`: half the fan's vertical opening, rad, for echoes without one of their
    own.
    """
    m = echoes.table.shape[1]
    predicted = np.empty((PREDICTED, 0)) if predicted is None else predicted
    position, rest, azimuth = np.empty((3, m)), np.empty((7, m)), np.empty((2, m))
    sensitivity = np.empty((UNSEEN, 2, m))
    native.measure_positions(echoes.table, predicted, vehicle, half_vertical, position, rest, azimuth, sensitivity)
    return PositionMeasurement(*(position, *rest, azimuth, sensitivity, vehicle.bias[:2] ** 2, vehicle.noise[2:] ** 2))
