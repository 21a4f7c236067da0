"""Images of earlier pings as they would look from where the vehicle is now."""

import numpy as np

from ods.base.arrays import Floats, Image
from ods.base.geometry import rotation_matrix
from ods.compiled.kernel import kernel
from ods.messages import Pose
from ods.pipeline.image.fan import Fan
from ods.runtime.pose_buffer import PoseEstimate

_KNOT = 32
"""Columns between two places whose way is computed exactly."""
Unknown = np.float32(-1.0)
"""Stands for cells that the former ping did not see."""


class MotionCompensator:
    """Resamples images taken from one pose to what they would show from another."""

    def __init__(self, fan: Fan) -> None:
        columns = np.minimum(np.arange(0, fan.samples - 1 + _KNOT, _KNOT), fan.samples - 1)
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
        resample(image, column, beam, out)


@kernel
def resample(image: Image, column: Floats, beam: Floats, out: Image) -> None:
    """Fill out with image at (beam, column), given at every 32nd column: nearest beam, interpolated in range."""
    beams, samples = image.shape
    for b in range(beams):
        for k in range(column.shape[1] - 1):
            begin, stop = k * _KNOT, min((k + 1) * _KNOT, samples)
            if k == column.shape[1] - 2:
                stop = samples
            length = max(1, min((k + 1) * _KNOT, samples - 1) - begin)
            for j in range(begin, stop):
                share = (j - begin) / length
                row = int(np.floor(beam[b, k] + share * (beam[b, k + 1] - beam[b, k]) + 0.5))
                place = column[b, k] + share * (column[b, k + 1] - column[b, k])
                left = int(np.floor(place))
                if row < 0 or row >= beams or left < 0 or left >= samples:
                    out[b, j] = Unknown
                    continue
                right = min(left + 1, samples - 1)
                weight = np.float32(place - left)
                out[b, j] = image[row, left] + weight * (image[row, right] - image[row, left])
