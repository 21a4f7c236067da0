"""Images of earlier pings as they would look from where the vehicle is now."""

import numpy as np

from ods.base.arrays import Image
from ods.base.frames.geometry import rotation_matrix
from ods.compiled import native
from ods.messages import Pose
from ods.pipeline.image.fan import Fan
from ods.pose.buffer import PoseEstimate

KNOT = 32
"""Columns between two places whose way is computed exactly."""
Unknown = np.float32(-1.0)
"""Stands for cells that the former ping did not see."""


class MotionCompensator:
    """Resamples images taken from one pose to what they would show from another."""

    def __init__(self, fan: Fan) -> None:
        columns = np.minimum(np.arange(0, fan.samples - 1 + KNOT, KNOT), fan.samples - 1)
        distance = fan.range0_m + columns * fan.dr_m
        angle = fan.bearing_rad[:, None]
        self._fan = fan
        self._points = np.stack([distance * np.cos(angle), distance * np.sin(angle), np.zeros_like(distance * angle)])
        self._number = np.arange(len(fan.bearing_rad), dtype=np.float64)

    def compensate(
        self, image: Image, before: Pose | PoseEstimate | None, now: Pose | PoseEstimate | None, out: Image
    ) -> None:
        """Fill out with image, taken at pose `before`, as seen from pose `now`; `Unknown` where it does not reach.

        All in the fan's plane, and of objects that stand still [SSIE eq. 1].
        """
        if before is None or now is None:
            out[:] = image
            return
        fan = self._fan
        away = np.subtract(now.position_ned, before.position_ned)
        old = rotation_matrix(before.attitude).T
        turned = np.tensordot(old @ rotation_matrix(now.attitude), self._points, 1) + (old @ away)[:, None, None]
        column = (np.hypot(turned[0], turned[1]) - fan.range0_m) / fan.dr_m
        bearing = np.arctan2(turned[1], turned[0])
        half = 0.5 * float(fan.beam_width_rad[0])
        beam = np.interp(bearing, fan.bearing_rad, self._number)
        beam[(bearing < fan.bearing_rad[0] - half) | (bearing > fan.bearing_rad[-1] + half)] = -1e6
        native.resample(image, column, beam, KNOT, Unknown, out)
