"""Is an object expected in this image, at the edge of the sector, or not at all?"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.kernel import kernel
from ods.messages import Sector
from ods.tracker.measurement import Sight

ROOT2 = 2.0**0.5
ROOT3 = 3.0**0.5
LEAST_SIGMA = 1e-6
"""Keeps the distance to the edge, in standard deviations, finite."""


class View(NamedTuple):
    """(n,) arrays."""

    inside: NDArray[np.bool_]
    """The predicted place is inside the sector."""
    probability: Array
    """That the object is inside the sector."""
    watched: Array
    """Probability that the sonar looks at the object: 0 unless it is so far inside that a missing echo says something,
    then the share of its vertical interval that the fan covers."""


def view(sight: Sight, sector: Sector, edge_sigmas: float) -> View:
    """Compare predictions with the sector; an object is watched that is at least `edge_sigmas` inside its edges.

    Vertically an object is anywhere in an interval as wide as its variance allows.
    """
    inside, shares = _view(sight, *_edges(sector), sector.half_vertical_rad, edge_sigmas)
    return View(inside, shares[0], shares[1])


@kernel
def _view(
    sight: Sight, nearest: float, farthest: float, port: float, starboard: float, half_vertical: float, margin: float
) -> tuple[NDArray[np.bool_], Array]:
    """Return the fields of `View`, the shares as (2, n)."""
    n = len(sight.range_m)
    inside, shares = np.empty(n, np.bool_), np.empty((2, n))
    for i in range(n):
        sigma_range = math.sqrt(sight.along[i]) + LEAST_SIGMA
        sigma_bearing = math.sqrt(sight.across[i]) / sight.horizontal[i] + LEAST_SIGMA
        to_edge = min(
            min(sight.range_m[i] - nearest, farthest - sight.range_m[i]) / sigma_range,
            min(sight.bearing[i] - port, starboard - sight.bearing[i]) / sigma_bearing,
        )
        covered = _covered(sight.range_m[i], sight.elevation[i], sight.vertical[i], half_vertical)
        inside[i] = to_edge >= 0.0 and covered > 0.0
        shares[0, i] = 0.5 * math.erfc(-to_edge / ROOT2)
        shares[1, i] = covered if to_edge >= margin else 0.0
    return inside, shares


@kernel
def _covered(distance: float, elevation: float, variance: float, half_vertical: float) -> float:
    """Return the share of an object's vertical interval that the fan covers."""
    half_fan = distance * math.sin(half_vertical)
    half_object = ROOT3 * math.sqrt(variance) + LEAST_SIGMA
    middle = distance * math.sin(elevation)
    shared = min(half_fan, middle + half_object) - max(-half_fan, middle - half_object)
    return max(shared, 0.0) / (2.0 * half_object)


def near_sector(sight: Sight, sector: Sector, margin_m: float) -> NDArray[np.bool_]:
    """Tell (n,) which predicted places are inside the sector or nearer to it than about `margin_m`."""
    return _near(sight, *_edges(sector), margin_m)


@kernel
def _near(
    sight: Sight, nearest: float, farthest: float, port: float, starboard: float, margin_m: float
) -> NDArray[np.bool_]:
    near = np.empty(len(sight.range_m), np.bool_)
    for i in range(len(near)):
        turn = margin_m / sight.horizontal[i]
        near[i] = (nearest - margin_m <= sight.range_m[i] <= farthest + margin_m) and (
            port - turn <= sight.bearing[i] <= starboard + turn
        )
    return near


def _edges(sector: Sector) -> tuple[float, float, float, float]:
    return sector.range_min_m, sector.range_max_m, sector.bearing_min_rad, sector.bearing_max_rad
