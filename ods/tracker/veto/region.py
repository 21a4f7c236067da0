"""Test whether an obstacle lies completely inside a region, in the horizontal plane and in depth."""

import math
from collections.abc import Sequence

from ods.messages import Obstacle, VetoRegion
from ods.tracker.settings import MARGIN_SIGMAS

Corner = tuple[float, float]


def lies_in(obstacle: Obstacle, region: VetoRegion) -> bool:
    """Return whether all of an obstacle's circle is inside, and all of its depth where the region has a span."""
    north, east, down = obstacle.position_ned
    if region.down_m is not None:
        half = obstacle.radius_m + MARGIN_SIGMAS * obstacle.sigma_position[2]
        if not (region.down_m[0] <= down - half and down + half <= region.down_m[1]):
            return False
    if region.centre_ne is not None:
        away = math.hypot(north - region.centre_ne[0], east - region.centre_ne[1])
        return away + obstacle.radius_m <= region.radius_m
    return _is_within(north, east, obstacle.radius_m, region.corners_ne)


def _is_within(north: float, east: float, radius: float, corners: Sequence[Corner]) -> bool:
    """Return whether a circle is inside a polygon: its centre is, by the even-odd rule, and no side is nearer."""
    sides = list(zip(corners, [*corners[1:], corners[0]], strict=True))
    inside = sum(_is_north_of(side, north, east) for side in sides) % 2 == 1
    return inside and all(_distance(side, north, east) >= radius for side in sides)


def _is_north_of(side: tuple[Corner, Corner], north: float, east: float) -> bool:
    """Return whether the way to the north from a point crosses a side."""
    (north_1, east_1), (north_2, east_2) = side
    if (east_1 > east) == (east_2 > east):
        return False
    return north < north_1 + (east - east_1) / (east_2 - east_1) * (north_2 - north_1)


def _distance(side: tuple[Corner, Corner], north: float, east: float) -> float:
    (north_1, east_1), (north_2, east_2) = side
    along_n, along_e = north_2 - north_1, east_2 - east_1
    squared = along_n * along_n + along_e * along_e
    part = ((north - north_1) * along_n + (east - east_1) * along_e) / squared if squared > 0.0 else 0.0
    part = min(max(part, 0.0), 1.0)
    return math.hypot(north - north_1 - part * along_n, east - east_1 - part * along_e)
