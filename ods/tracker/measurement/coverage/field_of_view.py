"""Field of view: the probability that an object is observed in an image."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled import native
from ods.messages import Sector
from ods.tracker.measurement.coverage.looked import ObservedRanges
from ods.tracker.measurement.model import PredictedMeasurement
from ods.tracker.measurement.scan import SMALLEST_SIGMA, Vehicle, nothing_unseen
from ods.tracker.named import Named
from ods.tracker.settings import MARGIN_SIGMAS

NOTHING_UNSEEN = nothing_unseen()
BEHIND_M = 0.3
"""Distance behind an echo from which on objects are hidden, m."""
LEAST_CHANCE = 0.05
"""That an object that was passed by, is hidden or in a blind part gives an echo nevertheless: its place is not known so
well."""


class FieldOfView(NamedTuple):
    """What the sonar sees of n predicted objects: (n,) arrays."""

    inside: Mask
    """The predicted place is inside the sector."""
    probability: Floats
    """That the object is inside the sector, at a range that was processed."""
    skipped: Mask
    """The predicted position is inside the sector, in a part more likely skipped or blind than observed."""
    unseen: Mask
    """The predicted position is inside the sector, in a part that the ping did not observe."""
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
    unseen: Floats = NOTHING_UNSEEN,
) -> FieldOfView:
    """Compare predictions with the sector; an object is watched that is at least `edge_sigmas` inside its edges.

    radius: (n,) m; processed_ranges_m, unseen: see `Scan`. An object gives an echo with the probability that one of its
    parts, which are normal about its middle with half its radius, is inside. Vertically an object is anywhere in an
    interval as wide as its variance allows.
    """
    processed_m = np.array(processed_ranges_m, np.float64).reshape(-1, 2)
    inside, skipped, unshown = flags = np.empty((3, len(radius)), np.bool_)
    probability, watched = shares = np.empty((2, len(radius)))
    native.field_of_view(predicted.table, radius, fan, processed_m, unseen, edge_sigmas, LEAST_CHANCE, flags, shares)
    return FieldOfView(inside, probability, skipped, unshown, watched)


def hidden_by(
    seen: FieldOfView, looked: ObservedRanges, predicted: Named[PredictedMeasurement], radius: Floats
) -> FieldOfView:
    """Return what the sonar sees, but for what is hidden behind a nearer echo in its direction, and its height."""
    table = predicted.rows
    margin_m = radius + MARGIN_SIGMAS * np.sqrt(table.along) + BEHIND_M
    hidden = seen.inside & looked.hides(table.range_m, table.bearing, table.elevation, margin_m)
    return FieldOfView(
        inside=seen.inside,
        probability=np.where(hidden, LEAST_CHANCE * seen.probability, seen.probability),
        skipped=seen.skipped | hidden,
        unseen=seen.unseen | hidden,
        watched=np.where(hidden, 0.0, seen.watched),
    )


def exclude_not_swept(
    seen: FieldOfView, predicted: Named[PredictedMeasurement], turn: float, not_swept: Floats
) -> None:
    """Take from what is seen the objects whose middle a mechanically scanned head did not come by, `Scan.not_swept`.

    What the ping observed is given by middles, so an object's width does not count here; that its middle may be
    elsewhere is.
    """
    rows = predicted.rows
    middle, sigma = rows.bearing - turn * rows.range_m, np.sqrt(rows.across) / rows.horizontal + SMALLEST_SIGMA
    elsewhere = np.zeros(len(middle))
    for low, high in not_swept:
        elsewhere += _below((high - middle) / sigma) - _below((low - middle) / sigma)
    swept = np.clip(1.0 - elsewhere, 0.0, 1.0)
    passed_by = swept < 0.5
    seen.probability[:] *= np.maximum(swept, LEAST_CHANCE)
    seen.watched[:] *= np.where(passed_by, 0.0, swept)
    seen.unseen[:] |= seen.inside & passed_by
    seen.skipped[:] |= seen.inside & passed_by


def _below(values: Floats) -> Floats:
    """Return the standard normal distribution at values."""
    return np.array([0.5 * math.erfc(-value / math.sqrt(2.0)) for value in values.tolist()])


def near_coverage(predicted: Named[PredictedMeasurement], fan: Coverage, margin_m: float) -> Mask:
    """Return (n,) bool: predicted positions inside the sector, or nearer to it than about `margin_m`."""
    near = np.empty(predicted.table.shape[1], np.bool_)
    native.near_coverage(predicted.table, fan, margin_m, near)
    return near


def in_opening(places: Floats, vehicle: Vehicle, fan: Coverage, margin_m: float) -> Mask:
    """Return (k,) bool: which (2, k) north-east positions are between the fan's bearings, or within `margin_m` of
    them."""
    inside = np.empty(places.shape[1], np.bool_)
    native.in_opening(places, vehicle, fan, margin_m, inside)
    return inside
