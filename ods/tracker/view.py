"""Is an object expected in this image, at the edge of the sector, or not at all?"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from ods.geometry import Array
from ods.messages import Sector
from ods.tracker.measurement import Sight

ROOT3 = 3.0**0.5
LEAST_SIGMA = 1e-6
"""Keeps the distance to the edge, in standard deviations, finite."""


@dataclass(frozen=True, slots=True)
class View:
    """(n,) arrays."""

    inside: NDArray[np.bool_]
    """The predicted place is inside the sector."""
    probability: Array
    """That the object is inside the sector, at a range that was processed."""
    skipped: NDArray[np.bool_]
    """The predicted place is inside the sector, at a range that was more likely left out than processed."""
    watched: Array
    """Probability that the sonar looks at the object: 0 unless it is so far inside that a missing echo says something,
    then the share of its vertical interval that the fan covers, times the probability that its range was
    processed."""


def view(sight: Sight, sector: Sector, looked: Sequence[tuple[float, float]], edge_sigmas: float) -> View:
    """Compare predictions with the sector; an object is watched that is at least `edge_sigmas` inside its edges.

    looked: ranges (from, to) that were processed; empty: all. Vertically an object is anywhere in an interval as wide
    as its variance allows.
    """
    sigma_range = np.sqrt(sight.along) + LEAST_SIGMA
    sigma_bearing = np.sqrt(sight.across) / sight.horizontal + LEAST_SIGMA
    to_edge = np.minimum(
        np.minimum(sight.range_m - sector.range_min_m, sector.range_max_m - sight.range_m) / sigma_range,
        np.minimum(sight.bearing - sector.bearing_min_rad, sector.bearing_max_rad - sight.bearing) / sigma_bearing,
    )
    covered = _covered(sight, sector.half_vertical_rad)
    inside = (to_edge >= 0.0) & (covered > 0.0)
    processed = np.ones_like(to_edge)
    if looked:
        borders = np.array(looked)[:, :, None]
        below = ndtr((borders - sight.range_m) / sigma_range)
        processed = (below[:, 1] - below[:, 0]).sum(axis=0)
    return View(
        inside=inside,
        probability=ndtr(to_edge) * processed,
        skipped=inside & (processed < 0.5),
        watched=np.where(to_edge >= edge_sigmas, covered * processed, 0.0),
    )


def near_sector(sight: Sight, sector: Sector, margin_m: float) -> NDArray[np.bool_]:
    """Tell (n,) which predicted places are inside the sector or nearer to it than about `margin_m`."""
    turn = margin_m / sight.horizontal
    near: NDArray[np.bool_] = (
        (sight.range_m >= sector.range_min_m - margin_m)
        & (sight.range_m <= sector.range_max_m + margin_m)
        & (sight.bearing >= sector.bearing_min_rad - turn)
        & (sight.bearing <= sector.bearing_max_rad + turn)
    )
    return near


def _covered(sight: Sight, half_vertical: float) -> Array:
    """Return (n,) the share of each object's vertical interval that the fan covers."""
    half_fan = sight.range_m * np.sin(half_vertical)
    half_object = ROOT3 * np.sqrt(sight.vertical) + LEAST_SIGMA
    middle = sight.range_m * np.sin(sight.elevation)
    shared = np.minimum(half_fan, middle + half_object) - np.maximum(-half_fan, middle - half_object)
    share: Array = np.maximum(shared, 0.0) / (2.0 * half_object)
    return share
