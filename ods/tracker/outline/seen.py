"""The echoes of one ping in the global frame: their places, near edges and extents, in the horizontal plane."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames.geometry import rotation_matrix
from ods.compiled import native
from ods.messages import Detection
from ods.pose.buffer import PoseEstimate


class GlobalEchoes(NamedTuple):
    """m echoes: (m,) each, or as said."""

    place: Floats
    """(m, 2) north and east, m."""
    radius: Floats
    """m."""
    sigma: Floats
    """Standard deviation of the place, m, the larger of along and across the line of sight."""
    near: Floats
    """Slant range of the near edge, m;"""
    sigma_near: Floats
    """its standard deviation, m."""
    sigma_along: Floats
    """Those of the place along the line of sight"""
    sigma_radius: Floats
    """and of the radius, m; NaN both where an echo is cut off: the tracker itself keeps what these have in common."""
    extent: Floats
    """(m, 2, 2) second moments of what is seen of it, north and east, m^2."""
    length: Floats
    """Half its length, m."""


def seen_from(head: PoseEstimate, echoes: Sequence[Detection], fan_turn: float, sound_speed: float) -> GlobalEchoes:
    """Return the echoes as `head`, the sonar's pose at transmission, would have measured them.

    fan_turn: how much the fan turns to starboard while an echo comes from a metre farther, rad/m. An echo from r was
    received 2 r / c later: the mean of both places is that much farther along the way. Echoes without a near edge or an
    outline, as in older recordings, are left out.
    """
    columns = np.array(
        [
            (*(d.range_m, d.bearing_rad, d.elevation_rad, d.radius_m, d.sigma_range_m, d.sigma_bearing_rad),
             *(d.near_m, d.sigma_near_m, d.half_length_m, d.half_width_m, d.axis_rad),
             math.nan if d.cut else d.sigma_radius_m)
            for d in echoes
            if d.sigma_near_m > 0.0 and d.half_length_m > 0.0
        ],
        np.float64,
    ).reshape(-1, 12)  # fmt: skip
    m = len(columns)
    place, extent, (*numbers, length) = np.empty((m, 2)), np.empty((m, 2, 2)), np.empty((7, m))
    seen = GlobalEchoes._make([place, *numbers, extent, length])
    pose = head.position_ned, rotation_matrix(head.attitude), head.velocity_ned
    native.see_outlines(columns, pose, fan_turn, sound_speed or math.inf, seen)
    return seen
