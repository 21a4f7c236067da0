"""Is an object expected in this image, at the edge of the sector, or not at all?"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled.kernel import kernel
from ods.messages import Sector
from ods.tracker.measurement.model import PredictedMeasurement, predicted_rows
from ods.tracker.measurement.scan import Vehicle
from ods.tracker.named import Named

ROOT2 = 2.0**0.5
ROOT3 = 3.0**0.5
HIDDEN_SHARE = 0.25
"""An object of which more than this is hidden by blind beams may be missed."""
LEAST_CHANCE = 0.05
"""That an object in a blind part gives an echo beside it: its place is not known so well."""
PARTS = 0.5
"""Standard deviation of where what gives an echo of an object lies, in radii from its middle."""
LEAST_SIGMA = 1e-6
"""Keeps the distance to the edge, in standard deviations, finite."""


class FieldOfView(NamedTuple):
    """What the sonar sees of n predicted objects: (n,) arrays."""

    inside: Mask
    """The predicted place is inside the sector."""
    probability: Floats
    """That the object is inside the sector, at a range that was processed."""
    skipped: Mask
    """The predicted place is inside the sector, where the image was more likely left out or blind than looked at."""
    unseen: Mask
    """The predicted place is inside the sector, in a part that the ping could not show."""
    watched: Floats
    """Probability that the sonar looks at the object: 0 where it was blind, and unless the object is so far inside that
    a missing echo says something, then the share of its vertical interval that the fan covers, times the probability
    that its range was processed."""


class Coverage(NamedTuple):
    """The sector that an image shows."""

    range_min_m: float
    range_max_m: float
    bearing_min: float
    """rad, to starboard."""
    bearing_max: float
    half_vertical: float
    """rad."""
    turn: float
    """See `Scan.fan_turn`."""


def coverage_of(sector: Sector, turn: float = 0.0) -> Coverage:
    """Return the fan of a sector."""
    return Coverage(
        *(sector.range_min_m, sector.range_max_m, sector.bearing_min_rad, sector.bearing_max_rad),
        sector.half_vertical_rad,
        turn,
    )


def field_of_view(
    predicted: Named[PredictedMeasurement],
    radius: Floats,
    fan: Coverage,
    processed_ranges_m: Sequence[tuple[float, float]],
    edge_sigmas: float,
) -> FieldOfView:
    """Compare predictions with the sector; an object is watched that is at least `edge_sigmas` inside its edges.

    radius: (n,) m; processed_ranges_m: see `Scan`. An object gives an echo with the probability that one of its parts,
    which are normal about its middle with half its radius, is inside. Vertically an object is anywhere in an interval
    as wide as its variance allows.
    """
    processed_m = np.array(processed_ranges_m, np.float64).reshape(-1, 2)
    (inside, skipped), (probability, watched) = _field_of_view(predicted.table, radius, fan, processed_m, edge_sigmas)
    return FieldOfView(inside, probability, skipped, np.zeros(len(inside), np.bool_), watched)


@kernel
def _field_of_view(
    table: Floats, radius: Floats, fan: Coverage, processed_m: Floats, edge_sigmas: float
) -> tuple[Mask, Floats]:
    """Return the fields of `FieldOfView`: (2, n) inside and skipped, (2, n) probability and watched."""
    predicted, n = predicted_rows(table), table.shape[1]
    flags, shares = np.empty((2, n), np.bool_), np.empty((2, n))
    inside, skipped = flags
    probability, watched = shares
    for i in range(n):
        distance = predicted.range_m[i]
        sigma_range = math.sqrt(predicted.along[i]) + LEAST_SIGMA
        sigma_bearing = math.sqrt(predicted.across[i]) / predicted.horizontal[i] + LEAST_SIGMA
        in_fan = predicted.bearing[i] - fan.turn * distance
        to_range = min(distance - fan.range_min_m, fan.range_max_m - distance)
        to_bearing = min(in_fan - fan.bearing_min, fan.bearing_max - in_fan)
        to_edge = min(to_range / sigma_range, to_bearing / sigma_bearing)
        parts_m = PARTS * max(radius[i], 0.0)
        to_part = min(
            to_range / math.hypot(sigma_range, parts_m),
            to_bearing / math.hypot(sigma_bearing, parts_m / predicted.horizontal[i]),
        )
        covered = _covered(distance, predicted.elevation[i], predicted.vertical[i], fan.half_vertical)
        processed = _processed(distance, sigma_range, processed_m)
        inside[i] = to_edge >= 0.0 and covered > 0.0
        skipped[i] = inside[i] and processed < 0.5
        probability[i] = _normal(to_part) * processed
        watched[i] = covered * processed if to_edge >= edge_sigmas else 0.0
    return flags, shares


@kernel
def _processed(distance: float, sigma: float, ranges: Floats) -> float:
    """Return the probability that the range of an object is one of `ranges`, (k, 2); 1 when there are none."""
    if len(ranges) == 0:
        return 1.0
    total = 0.0
    for begin, stop in ranges:
        total += _normal((stop - distance) / sigma) - _normal((begin - distance) / sigma)
    return total


@kernel
def _normal(deviate: float) -> float:
    """Return the standard normal distribution function."""
    return 0.5 * math.erfc(-deviate / ROOT2)


@kernel
def _covered(distance: float, elevation: float, variance: float, half_vertical: float) -> float:
    """Return the share of an object's vertical interval that the fan covers."""
    half_fan = distance * math.sin(half_vertical)
    half_object = ROOT3 * math.sqrt(variance) + LEAST_SIGMA
    middle = distance * math.sin(elevation)
    shared = min(half_fan, middle + half_object) - max(-half_fan, middle - half_object)
    return max(shared, 0.0) / (2.0 * half_object)


def without_unseen(seen: FieldOfView, covered: Floats) -> FieldOfView:
    """Return what the sonar sees of objects whose shares `covered`, (n,), lie in parts that the ping did not show."""
    unseen = seen.inside & (covered > HIDDEN_SHARE)
    return seen._replace(
        probability=seen.probability * np.maximum(1.0 - covered, LEAST_CHANCE),
        skipped=seen.skipped | unseen,
        unseen=unseen,
        watched=np.where(unseen, 0.0, seen.watched),
    )


def share_unseen(predicted: Named[PredictedMeasurement], radius: Floats, fan: Coverage, unseen: Floats) -> Floats:
    """Return (n,) the share of each object's bearings that lies in parts the ping did not show.

    `radius`: (n,) m; `unseen`: see `Scan`.
    """
    return _share_unseen(predicted.table, radius, fan.turn, unseen)


@kernel
def _share_unseen(table: Floats, radius: Floats, turn: float, unseen: Floats) -> Floats:
    predicted, covered = predicted_rows(table), np.zeros(len(radius))
    for i in range(len(radius)):
        distance = predicted.range_m[i]
        middle = predicted.bearing[i] - turn * distance
        sigma = math.sqrt(predicted.across[i])
        half = max(radius[i], sigma, LEAST_SIGMA) / predicted.horizontal[i]
        for low, high, near, far in unseen:
            if near - radius[i] <= distance <= far + radius[i]:
                shared = min(high, middle + half) - max(low, middle - half)
                covered[i] += max(shared, 0.0) / (2.0 * half)
        covered[i] = min(covered[i], 1.0)
    return covered


def near_coverage(predicted: Named[PredictedMeasurement], fan: Coverage, margin_m: float) -> Mask:
    """Tell (n,) which predicted places are inside the sector or nearer to it than about `margin_m`."""
    return _near_fan(predicted.table, fan, margin_m)


@kernel
def _near_fan(table: Floats, fan: Coverage, margin_m: float) -> Mask:
    predicted, near = predicted_rows(table), np.empty(table.shape[1], np.bool_)
    for i in range(len(near)):
        turn = margin_m / predicted.horizontal[i]
        near[i] = (fan.range_min_m - margin_m <= predicted.range_m[i] <= fan.range_max_m + margin_m) and (
            fan.bearing_min - turn <= predicted.bearing[i] <= fan.bearing_max + turn
        )
    return near


def occluded(predicted: Named[PredictedMeasurement], radius: Floats, asked: Mask, hiding: Mask) -> Mask:
    """Tell (n,) which of `asked` are predicted behind a nearer object, one of `hiding`, as seen from the sonar.

    `radius`: (n,) m. The shadow is as wide as the object in front, and the standard deviation of the bearing wider.
    """
    return _occluded(predicted.table, radius, asked, hiding)


@kernel
def _occluded(table: Floats, radius: Floats, asked: Mask, hiding: Mask) -> Mask:
    predicted, n = predicted_rows(table), table.shape[1]
    behind = np.zeros(n, np.bool_)
    for i in range(n):
        if not asked[i]:
            continue
        sigma = math.sqrt(predicted.across[i]) / predicted.horizontal[i]
        for front in range(n):
            if hiding[front] and predicted.range_m[i] > predicted.range_m[front] + radius[front]:
                half_width = math.asin(min(radius[front] / predicted.range_m[front], 1.0))
                behind[i] |= abs(predicted.bearing[i] - predicted.bearing[front]) <= half_width + sigma
    return behind


@kernel
def in_opening(places: Floats, vehicle: Vehicle, fan: Coverage, margin_m: float) -> Mask:
    """Tell which (2, k) north-east places are between the fan's bearings, or not farther off than `margin_m`."""
    inside = np.empty(places.shape[1], np.bool_)
    for i in range(len(inside)):
        north, east = places[0, i] - vehicle.position[0], places[1, i] - vehicle.position[1]
        ahead = vehicle.rotation[0, 0] * north + vehicle.rotation[1, 0] * east
        side = vehicle.rotation[0, 1] * north + vehicle.rotation[1, 1] * east
        bearing = math.atan2(side, ahead)
        margin = margin_m / max(math.hypot(north, east), margin_m)
        inside[i] = bearing + margin >= fan.bearing_min and bearing - margin <= fan.bearing_max
    return inside
