"""Is an object expected in this image, at the edge of the sector, or not at all?"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.messages import Sector
from ods.tracker.measurement import Sight

ROOT3 = 3.0**0.5


@dataclass(frozen=True, slots=True)
class View:
    """(n,) arrays."""

    inside: NDArray[np.bool_]
    """The predicted place is inside the sector."""
    watched: Array
    """Probability that the sonar looks at the object: 0 unless it is so far inside that a missing echo says something,
    then the share of its vertical interval that the fan covers."""


def view(sight: Sight, sector: Sector, edge_sigmas: float) -> View:
    """Compare predictions with the sector; for `watched` its edges are moved in by `edge_sigmas` standard deviations.

    Vertically an object is anywhere in an interval as wide as its variance allows.
    """
    range_margin = edge_sigmas * np.sqrt(sight.along)
    bearing_margin = edge_sigmas * np.sqrt(sight.across) / sight.horizontal
    covered = _covered(sight, sector.half_vertical_rad)
    well_inside = _in_sector(sight, sector, range_margin, bearing_margin)
    return View(
        inside=_in_sector(sight, sector, 0.0, 0.0) & (covered > 0.0), watched=np.where(well_inside, covered, 0.0)
    )


def near_sector(sight: Sight, sector: Sector, margin_m: float) -> NDArray[np.bool_]:
    """Tell (n,) which predicted places are inside the sector or nearer to it than about `margin_m`."""
    return _in_sector(sight, sector, -margin_m, -margin_m / sight.horizontal)


def _in_sector(
    sight: Sight, sector: Sector, range_margin: Array | float, bearing_margin: Array | float
) -> NDArray[np.bool_]:
    inside: NDArray[np.bool_] = (
        (sight.range_m - range_margin >= sector.range_min_m)
        & (sight.range_m + range_margin <= sector.range_max_m)
        & (sight.bearing - bearing_margin >= sector.bearing_min_rad)
        & (sight.bearing + bearing_margin <= sector.bearing_max_rad)
    )
    return inside


def _covered(sight: Sight, half_vertical: float) -> Array:
    """Return (n,) the share of each object's vertical interval that the fan covers."""
    half_fan = sight.range_m * np.sin(half_vertical)
    half_object = ROOT3 * np.sqrt(sight.vertical) + 1e-6
    middle = sight.range_m * np.sin(sight.elevation)
    shared = np.minimum(half_fan, middle + half_object) - np.maximum(-half_fan, middle - half_object)
    share: Array = np.maximum(shared, 0.0) / (2.0 * half_object)
    return share
