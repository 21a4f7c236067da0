"""The bottom as the image shows it, where the pose does not tell the altitude over it."""

import math

import numpy as np

from ods.base.clock import NS
from ods.base.geometry import rotation_matrix
from ods.messages import BottomEcho, Detections
from ods.runtime.pose_buffer import PoseEstimate
from ods.tracker.output.bottom import Bottom, bottom_below

RELATIVE = 0.14
"""Standard deviation of a height by where the bottom's echo sets in: pattern, grazing angle, highlights."""
ALIKE = 0.35
"""Heights by several groups of beams are of one bottom if they differ from their median by no more than this share."""
MAD_SIGMA = 1.48
"""Standard deviation of the normal law over the median of what is off its middle."""
CLEAR_OF_SURFACE = 1.3
"""The surface must be so many times farther from the fan's upper side than what is taken for the bottom."""
KEPT_S = 5.0
"""It is known for so long after it was seen last."""


def bottom_seen(echo: BottomEcho, head: PoseEstimate, surface_down_m: float) -> Bottom | None:
    """Return the bottom where the fan's lower side meets it; None where it may be the surface, or groups disagree.

    surface_down_m: down coordinate of the surface.
    """
    bearing, ranges = np.array(echo.bearing_rad), np.array(echo.range_m)
    level, below = math.cos(echo.below_rad), math.sin(echo.below_rad)
    ahead = np.array([level * np.cos(bearing), level * np.sin(bearing), np.full(len(bearing), below)])
    rotation = rotation_matrix(head.attitude)
    way = rotation @ ahead * ranges
    rises = -(rotation @ (ahead * [[1.0], [1.0], [-1.0]]) * ranges)[2]
    median = float(np.median(way[2]))
    alike = np.abs(way[2] - median) <= ALIKE * median
    if not median > 0.0 or alike.sum() * 2 < len(alike):
        return None
    if head.position_ned[2] - surface_down_m < CLEAR_OF_SURFACE * float(np.median(rises)):
        return None
    heights = way[2, alike]
    height = float(np.median(heights))
    spread = MAD_SIGMA * float(np.median(np.abs(heights - height)))
    tilt = float(head.sigma_attitude[:2].max()) * float(np.median(ranges[alike]))
    place = head.position_ned + np.array([*way[:2, alike].mean(axis=1), height])
    return Bottom(place, math.hypot(RELATIVE * height, 0.5 * spread, tilt, float(head.sigma_position[2])))


class BottomKnown:
    """The bottom as it is known: by the pose's altitude, else by the images of the last seconds."""

    def __init__(self, surface_down_m: float) -> None:
        """`surface_down_m`: down coordinate of the surface."""
        self._surface_down_m = surface_down_m
        self._seen: Bottom | None = None
        self._seen_ns = 0

    def hear(self, message: Detections, head: PoseEstimate | None) -> None:
        """Take in what a ping shows; head: the sonar's pose at transmission."""
        if message.bottom_echo is None or head is None:
            return
        seen = bottom_seen(message.bottom_echo, head, self._surface_down_m)
        if seen is not None:
            self._seen, self._seen_ns = seen, message.t_ns

    def at(self, t_ns: int, vehicle: PoseEstimate | None) -> Bottom | None:
        """Return the bottom at an instant, at which the vehicle, or the sonar's head, has that pose."""
        told = bottom_below(vehicle)
        if told is not None or abs(t_ns - self._seen_ns) > KEPT_S * NS:
            return told
        return self._seen
