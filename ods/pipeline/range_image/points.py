"""The pixels of a range image as points: in the frame of the sonar's head, and level."""

from functools import cached_property
from typing import NamedTuple

from ods.base.arrays import Floats, Floats32, Mask
from ods.base.frames.geometry import body_to_global, body_to_polar, global_to_body, polar_to_body


class Head(NamedTuple):
    """The sonar's head."""

    position: Floats
    """(3,) NED, m."""
    attitude: Floats
    """(4,) head to global."""

    def to_global(self, in_head: Floats) -> Floats:
        """Return (..., 3) points in NED of points in the head's frame."""
        return body_to_global(in_head, self.position, self.attitude)

    def to_polar(self, point_ned: Floats) -> tuple[float, float, float]:
        """Return range, bearing and elevation of a (3,) point."""
        seen = body_to_polar(global_to_body(point_ned, self.position, self.attitude))
        distance, bearing, elevation = (float(each) for each in seen)
        return distance, bearing, elevation


class RangePixels:
    """The pixels of one image."""

    def __init__(self, range_m: Floats32, wanted: Mask, bearing_rad: Floats, elevation_rad: Floats, head: Head) -> None:
        """`range_m`: (bearings, elevations); `wanted`: those that have an echo that counts."""
        self.range_m, self.wanted = range_m, wanted
        self.bearing_rad, self.elevation_rad, self.head = bearing_rad, elevation_rad, head
        self.spacing_rad = _spacing(bearing_rad), _spacing(elevation_rad)
        """From pixel to pixel, across and up."""

    @cached_property
    def points_ned(self) -> Floats:
        """(bearings, elevations, 3)."""
        in_head = polar_to_body(self.range_m, self.bearing_rad[:, None], self.elevation_rad[None, :])
        return self.head.to_global(in_head)


def _spacing(angles: Floats) -> float:
    return float(angles[-1] - angles[0]) / max(1, angles.size - 1)
