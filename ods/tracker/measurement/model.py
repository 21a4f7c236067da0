"""Between the sonar's polar measurements and the global frame: eq. 1 with the pose at the ping, and its covariance.

The fan has no resolution in elevation: a measurement is a range and a bearing, and a vertical interval. Where the
object is, north and east, follows only for a given height: what is measured is a curve, told as a parabola in height.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel
from ods.tracker.measurement.scan import Echoes, Vehicle, echo_rows
from ods.tracker.named import Named

Three = tuple[float, float, float]

NEAREST_M = 1e-3
"""Horizontal distances are kept above this, so that a direction exists."""
STEEPEST = 0.2
"""Range and bearing do not tell the horizontal place of an object straight above or below: no line of sight is taken to
be steeper than that this share of the distance is horizontal."""
MOST_BENT = 0.25
"""What a place across the line of sight may add to the square of the range: at most this share of it."""
HEIGHT, BEND, ATTITUDE, CLIMB = 0, 1, 2, 3
"""What the ping does not see, but the horizontal place depends on: the height, its square, the bias of the attitude,
and what earlier pings were told by, how much the height changes."""
UNSEEN = 4


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


@kernel
def predicted_rows(table: Floats) -> PredictedMeasurement:
    """Name the rows of an (8, ...) table."""
    return PredictedMeasurement(table[0], table[1], table[2], table[3], table[4], table[5], table[6], table[7])


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
    """(2,) of the vehicle's own north and east, m^2."""


@kernel
def wrapped(angle: float) -> float:
    """Return the angle wrapped to [-pi, pi)."""
    if -math.pi <= angle < math.pi:
        return angle
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


class Places(NamedTuple):
    """Where objects are believed to be: h hypotheses of n objects."""

    position: Floats
    """(h, 3, n) NED."""
    variance: Floats
    """(h, 3, n): of north and east at a given height, and of the height."""
    covariance_ne: Floats
    """(h, n) of north and east at a given height."""
    by_height: Floats
    """(h, 2, n) by how much north and east are larger for each metre that the object is lower."""


def predicted_measurement(
    position: Floats, variance: Floats, covariance_ne: Floats, vehicle: Vehicle, by_height: Floats | None = None
) -> Named[PredictedMeasurement]:
    """Predict what the sonar measures of objects: eq. 1 solved for the body frame, and the covariance.

    The arrays are fields of `Places`, of h hypotheses or, without the first axis, of one; `by_height` None: all 0.
    """
    if by_height is None:
        by_height = np.zeros((*position.shape[:-2], 2, position.shape[-1]))
    if position.ndim == 2:
        one = Places(position[None], variance[None], covariance_ne[None], by_height[None])
        return Named(PredictedMeasurement, _predicted_measurement(one, vehicle)[:, 0])
    places = Places(position, variance, covariance_ne, by_height)
    return Named(PredictedMeasurement, _predicted_measurement(places, vehicle))


class Sight(NamedTuple):
    """How the sonar sees a place, and by how much that changes for each metre north, east and down."""

    range_m: float
    bearing: float
    elevation: float
    horizontal: float
    farther: Three
    """Change of the range,"""
    aside: Three
    """and of the bearing, times the horizontal distance."""


@kernel
def _sight(x: float, y: float, z: float, rotation: Floats) -> Sight:
    """Return how the place (x, y, z) from the sonar, NED, is seen."""
    ahead = rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z
    right = rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z
    below = rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z
    horizontal = max(math.hypot(x, y), NEAREST_M)
    in_plane = max(math.hypot(ahead, right), NEAREST_M)
    slant = max(math.hypot(in_plane, below), NEAREST_M)
    turn = horizontal / in_plane**2
    aside = (
        turn * (ahead * rotation[0, 1] - right * rotation[0, 0]),
        turn * (ahead * rotation[1, 1] - right * rotation[1, 0]),
        turn * (ahead * rotation[2, 1] - right * rotation[2, 0]),
    )
    bearing, elevation = math.atan2(right, ahead), math.atan2(-below, in_plane)
    return Sight(slant, bearing, elevation, horizontal, (x / slant, y / slant, z / slant), aside)


@kernel
def _covariance(a: Three, b: Three, variance: Three, covariance_ne: float) -> float:
    """Return a' P b for the P of north, east and down, which is not correlated with them."""
    diagonal = a[0] * b[0] * variance[0] + a[1] * b[1] * variance[1] + a[2] * b[2] * variance[2]
    return diagonal + (a[0] * b[1] + a[1] * b[0]) * covariance_ne


@kernel
def _predicted_measurement(places: Places, vehicle: Vehicle) -> Floats:
    """Return (8, h, n) predictions for h hypotheses."""
    position, variance, covariance_ne, by_height = places
    s_nn, s_ee, s_dd = vehicle.sigma_position[0] ** 2, vehicle.sigma_position[1] ** 2, vehicle.sigma_position[2] ** 2
    tilt = max(vehicle.sigma_attitude[0] ** 2, vehicle.sigma_attitude[1] ** 2)
    yaw = vehicle.sigma_attitude[2] ** 2
    hypotheses, n = covariance_ne.shape
    table = np.empty((PREDICTED, hypotheses, n))
    made = predicted_rows(table)
    for h in range(hypotheses):
        for i in range(n):
            x = position[h, 0, i] - vehicle.position[0]
            y = position[h, 1, i] - vehicle.position[1]
            seen = _sight(x, y, position[h, 2, i] - vehicle.position[2], vehicle.rotation)
            farther, aside, square = seen.farther, seen.aside, seen.horizontal**2
            own = variance[h, 0, i], variance[h, 1, i], 0.0
            pose = s_nn, s_ee, s_dd + square * tilt
            mixed, height = covariance_ne[h, i], variance[h, 2, i]
            # An object that is lower is also farther north and east: what of that is seen.
            lower = by_height[h, 0, i], by_height[h, 1, i], 1.0
            farther_lower = farther[0] * lower[0] + farther[1] * lower[1] + farther[2]
            aside_lower = aside[0] * lower[0] + aside[1] * lower[1] + aside[2]
            own_along = _covariance(farther, farther, own, mixed)
            # What is uncertain across the line of sight makes the range longer than the distance to the middle.
            bent = min(max(own[0] + own[1] - own_along, 0.0), MOST_BENT * seen.range_m**2)
            made.range_m[h, i] = math.sqrt(seen.range_m**2 + bent)
            made.bearing[h, i], made.elevation[h, i], made.horizontal[h, i] = (
                seen.bearing,
                seen.elevation,
                seen.horizontal,
            )
            made.along[h, i] = own_along + _covariance(farther, farther, pose, 0.0) + farther_lower**2 * height
            made.across[h, i] = (
                _covariance(aside, aside, own, mixed) + _covariance(aside, aside, pose, 0.0) + aside_lower**2 * height
            ) + square * yaw
            made.mixed[h, i] = (
                _covariance(farther, aside, own, mixed) + _covariance(farther, aside, pose, 0.0)
            ) + farther_lower * aside_lower * height
            made.vertical[h, i] = height + pose[2]
    return table


NEW = np.zeros((PREDICTED, 0))
"""No prediction: the echoes are of new objects."""


def position_measurement(
    echoes: Echoes, vehicle: Vehicle, half_vertical: float, predicted: Floats = NEW
) -> PositionMeasurement:
    """Return eq. 1, z_og = z_ag + R^-1 z_ob, for all echoes, with measurement noise that includes the pose's.

    `predicted`: (8, m), the table of `PredictedMeasurement`, of the objects already tracked that the echoes are of.
    Range and bearing are then taken in where the object should be, along the tangent there: across wide beams the noise
    would bend the ellipse, and turn it anew with each echo. A new object is where its echo is, in the fan's middle.
    `half_vertical`: half the fan's vertical opening, rad, for echoes that tell none of their own.
    """
    made = _position_measurement(echoes.table, predicted, vehicle, half_vertical)
    place, (nn, ee, ne, *others), azimuth, sensitivity = made
    half_height, radius, radius_variance, height = others
    return PositionMeasurement(
        *(place, nn, ee, ne, half_height, radius, radius_variance, height, azimuth, sensitivity),
        vehicle.sigma_position[:2] ** 2,
    )


class Curve(NamedTuple):
    """Where an object seen at a range and bearing can be, and how that changes: north and east."""

    per_range: tuple[float, float]
    """Change per metre of range,"""
    per_bearing: tuple[float, float]
    """per rad of bearing,"""
    by_height: tuple[float, float]
    """per metre that the object is lower,"""
    bend: tuple[float, float]
    """and per m^2 of that."""


@kernel
def curve_at(place: Three, bearing: tuple[float, float], rotation: Floats) -> Curve:
    """Return how the horizontal place changes at `place` from the sonar, NED; bearing: its sine and cosine.

    |place| is the range, and place . n = 0, n the normal of the half-plane of the bearing. Both hold at every height;
    that the first is a square bends the curve.
    """
    x, y, z = place
    sine, cosine = bearing
    n_n = cosine * rotation[0, 1] - sine * rotation[0, 0]
    n_e = cosine * rotation[1, 1] - sine * rotation[1, 0]
    n_d = cosine * rotation[2, 1] - sine * rotation[2, 0]
    ahead = cosine * rotation[0, 0] + sine * rotation[0, 1], cosine * rotation[1, 0] + sine * rotation[1, 1]
    in_plane = ahead[0] * x + ahead[1] * y + (cosine * rotation[2, 0] + sine * rotation[2, 1]) * z
    slant = max(math.sqrt(x * x + y * y + z * z), NEAREST_M)
    determinant = x * n_e - y * n_n
    determinant = math.copysign(max(abs(determinant), STEEPEST * slant), determinant)
    away = n_e / determinant, -n_n / determinant
    aside = -y / determinant, x / determinant
    by_height = -away[0] * z - aside[0] * n_d, -away[1] * z - aside[1] * n_d
    bent = -0.5 * (1.0 + by_height[0] ** 2 + by_height[1] ** 2)
    return Curve(
        (slant * away[0], slant * away[1]),
        (in_plane * aside[0], in_plane * aside[1]),
        by_height,
        (bent * away[0], bent * away[1]),
    )


class Aim(NamedTuple):
    """Where range and bearing of an echo are taken in."""

    range_m: float
    bearing: float
    elevation: float
    across: float
    """Variance of the object's place across the line of sight, m^2."""


@kernel
def _from_sonar(distance: float, bearing: tuple[float, float], elevation: float, rotation: Floats) -> Three:
    """Return a place relative to the sonar, NED; bearing: its sine and cosine."""
    in_plane, below = distance * math.cos(elevation), -distance * math.sin(elevation)
    ahead, right = in_plane * bearing[1], in_plane * bearing[0]
    return (
        rotation[0, 0] * ahead + rotation[0, 1] * right + rotation[0, 2] * below,
        rotation[1, 0] * ahead + rotation[1, 1] * right + rotation[1, 2] * below,
        rotation[2, 0] * ahead + rotation[2, 1] * right + rotation[2, 2] * below,
    )


@kernel
def _position_measurement(
    table: Floats, predicted_table: Floats, vehicle: Vehicle, half_vertical: float
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the fields of `PositionMeasurement`: position, (7, m) variances to height, azimuth, sensitivity."""
    echoes, predicted, m = echo_rows(table), predicted_rows(predicted_table), table.shape[1]
    rotation, yaw = vehicle.rotation, vehicle.sigma_attitude[2]
    tilt = max(vehicle.sigma_attitude[0], vehicle.sigma_attitude[1])
    position, rest, sensitivity = np.empty((3, m)), np.empty((7, m)), np.empty((UNSEEN, 2, m))
    azimuth = np.empty((2, m))
    variance_north, variance_east, covariance_ne, half_height, radius, radius_variance, height = rest
    upright = abs(rotation[2, 2])
    is_new = predicted_table.shape[1] == 0
    for j in range(m):
        distance, bearing, level = echoes.range_m[j], echoes.bearing[j], echoes.elevation[j]
        half = echoes.half_vertical[j] if echoes.half_vertical[j] > 0.0 else half_vertical
        if is_new:  # its echo is where it is
            across = (distance * math.cos(level)) ** 2 * (echoes.sigma_bearing[j] ** 2 + yaw**2)
            aim = Aim(distance, bearing, level, across)
        else:
            elevation = min(max(predicted.elevation[j], level - half), level + half)
            aim = Aim(predicted.range_m[j], predicted.bearing[j], elevation, predicted.across[j])
        turned = math.sin(aim.bearing), math.cos(aim.bearing)
        x, y, z = _from_sonar(aim.range_m, turned, aim.elevation, rotation)
        curve = curve_at((x, y, z), turned, rotation)
        longer = 0.5 * min(aim.across, MOST_BENT * aim.range_m**2) / aim.range_m
        farther, aside = distance - aim.range_m - longer, wrapped(bearing - aim.bearing)
        s_range, s_bearing = echoes.sigma_range[j] ** 2 + 2.0 * longer**2, echoes.sigma_bearing[j] ** 2 + yaw**2
        along_n, along_e = curve.per_range
        across_n, across_e = curve.per_bearing
        position[0, j] = vehicle.position[0] + x + along_n * farther + across_n * aside
        position[1, j] = vehicle.position[1] + y + along_e * farther + across_e * aside
        # The height measured is that of the fan's middle, wherever in the fan the object is.
        middle = _from_sonar(aim.range_m, turned, level, rotation)
        position[2, j] = vehicle.position[2] + middle[2]
        variance_north[j] = along_n**2 * s_range + across_n**2 * s_bearing + vehicle.sigma_position[0] ** 2
        variance_east[j] = along_e**2 * s_range + across_e**2 * s_bearing + vehicle.sigma_position[1] ** 2
        covariance_ne[j] = along_n * along_e * s_range + across_n * across_e * s_bearing
        half_fan = aim.range_m * (math.sin(half) * upright)
        half_height[j] = half_fan + vehicle.sigma_position[2] + math.hypot(x, y) * tilt
        radius[j], radius_variance[j] = echoes.radius[j], echoes.sigma_radius[j] ** 2
        height[j] = vehicle.position[2] + z
        horizontal_2 = max(x**2 + y**2, (STEEPEST * aim.range_m) ** 2)
        azimuth[0, j], azimuth[1, j] = -y / horizontal_2, x / horizontal_2
        for axis in range(2):
            sensitivity[HEIGHT, axis, j], sensitivity[BEND, axis, j] = curve.by_height[axis], curve.bend[axis]
        height_variance = half_fan**2 / 3.0 if is_new else predicted.vertical[j]
        # A tilt turns what is higher or lower than the sonar aside, as a yaw does all.
        biased = math.sqrt(yaw**2 + tilt**2 * (z**2 + height_variance) / horizontal_2)
        sensitivity[ATTITUDE, 0, j], sensitivity[ATTITUDE, 1, j] = -biased * y, biased * x
        sensitivity[CLIMB, 0, j], sensitivity[CLIMB, 1, j] = 0.0, 0.0
    return position, rest, azimuth, sensitivity
