"""The pixels of a range image as points: in the frame of the sonar's head, and level."""

from functools import cached_property

import numpy as np

from ods.base.arrays import Floats, Floats32, Mask
from ods.base.frames.geometry import body_to_global, body_to_polar, global_to_body, polar_to_body
from ods.messages import Pose
from ods.pose.buffer import PoseEstimate


class RangePixels:
    """The pixels of one image."""

    def __init__(
        self,
        range_m: Floats32,
        wanted: Mask,
        bearing_rad: Floats,
        elevation_rad: Floats,
        head: Pose | PoseEstimate | None,
    ) -> None:
        """`range_m`: (bearings, elevations); `wanted`: those that have an echo that counts.

        `head`: its pose; None: level and at the origin.
        """
        self.range_m, self.wanted = range_m, wanted
        self.bearing_rad, self.elevation_rad = bearing_rad, elevation_rad
        self.spacing_rad = _spacing(bearing_rad), _spacing(elevation_rad)
        """From pixel to pixel, across and up."""
        self.position = np.zeros(3) if head is None else np.array(head.position_ned)
        """(3,) of the head, NED, m."""
        self._attitude = np.array([1.0, 0.0, 0.0, 0.0]) if head is None else np.array(head.attitude)

    @cached_property
    def points_ned(self) -> Floats:
        """(bearings, elevations, 3)."""
        in_head = polar_to_body(self.range_m, self.bearing_rad[:, None], self.elevation_rad[None, :])
        return body_to_global(in_head, self.position, self._attitude)

    def to_polar(self, point_ned: Floats) -> tuple[float, float, float]:
        """Return range, bearing and elevation of a (3,) point, as seen from the head."""
        seen = body_to_polar(global_to_body(point_ned, self.position, self._attitude))
        distance, bearing, elevation = (float(each) for each in seen)
        return distance, bearing, elevation


def _spacing(angles: Floats) -> float:
    return float(angles[-1] - angles[0]) / max(1, angles.size - 1)
