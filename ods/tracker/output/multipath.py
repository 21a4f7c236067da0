"""Obstacles that are likely echoes of others by a longer way (`Detections.second_ways_m`)."""

from collections.abc import Sequence

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.messages import Obstacle

SAME_M, ACROSS_RAD = 0.7, 0.02
"""An echo by the longer way is so near to its place, beside three standard deviations; across it by this much more for
the distance."""


def marked(obstacles: list[Obstacle], head_ned: Floats, longer_m: Sequence[float]) -> list[Obstacle]:
    """Return obstacles with `multipath_of` of those that are likely none.

    head_ned: (3,) of the sonar; longer_m: by how much ways are longer by which all is received once more, m.
    """
    if not longer_m or len(obstacles) < 2:
        return obstacles
    place = np.array([each.position_ned for each in obstacles])[:, :2] - head_ned[:2]
    sigma = np.array([max(each.sigma_position[:2]) for each in obstacles])
    away = np.hypot(*place.T)
    near = away - [each.radius_m for each in obstacles]
    unit = place / np.maximum(away, 1e-3)[:, None]
    across = np.abs(unit[:, None, 0] * unit[None, :, 1] - unit[:, None, 1] * unit[None, :, 0]) * away
    ahead = unit @ unit.T > 0.0
    sigmas = 3.0 * np.hypot(sigma[:, None], sigma[None, :])
    behind = near[None, :] - near[:, None]  # of the column's behind the row's
    off = np.min([np.abs(behind - each) for each in longer_m], axis=0)
    is_echo = ahead & (behind > 0.0) & (off <= SAME_M + sigmas) & (across <= SAME_M + ACROSS_RAD * away + sigmas)
    is_echo &= ~is_echo.any(axis=0)[:, None]  # none is the echo of an echo
    return [
        msgspec.structs.replace(each, multipath_of=obstacles[int(np.argmax(column))].id) if column.any() else each
        for each, column in zip(obstacles, is_echo.T, strict=True)
    ]
