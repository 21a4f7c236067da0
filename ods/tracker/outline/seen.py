"""The echoes of one ping in the global frame: their places, near edges and extents, in the horizontal plane."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames.geometry import polar_to_body, rotation_matrix
from ods.messages import Detection
from ods.pose.buffer import PoseEstimate


class Seen(NamedTuple):
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
    extent: Floats
    """(m, 2, 2) second moments of what is seen of it, north and east, m^2."""
    length: Floats
    """Half its length, m."""


def seen_from(head: PoseEstimate, echoes: Sequence[Detection], fan_turn: float, sound_speed: float) -> Seen:
    """Return the echoes as `head`, the sonar's pose at transmission, would have measured them.

    fan_turn: how much the fan turns to starboard while an echo comes from a metre farther, rad/m. An echo from r was
    received 2 r / c later: the mean of both places is that much farther along the way. Echoes without a near edge or an
    outline, as in older recordings, are left out.
    """
    columns = np.array(
        [
            (*(d.range_m, d.bearing_rad, d.elevation_rad, d.radius_m, d.sigma_range_m, d.sigma_bearing_rad),
             *(d.near_m, d.sigma_near_m, d.half_length_m, d.half_width_m, d.axis_rad))
            for d in echoes
            if d.sigma_near_m > 0.0 and d.half_length_m > 0.0
        ]
    )  # fmt: skip
    distance, bearing, elevation, radius, along, turned, near, sigma_near, length, width, axis = columns.reshape(
        -1, 11
    ).T
    bearing = bearing + fan_turn * distance
    body = polar_to_body(1.0, bearing, elevation)
    sight = body @ rotation_matrix(head.attitude).T
    moved = distance / (sound_speed or np.inf) * (sight @ head.velocity_ned)
    place = head.position_ned[:2] + (distance + moved)[:, None] * sight[:, :2]
    azimuth = np.arctan2(sight[:, 1], sight[:, 0]) + axis
    c, s = np.cos(azimuth), np.sin(azimuth)
    both, gap = (length**2 + width**2) / 6.0, (length**2 - width**2) / 6.0
    cosine, sine = gap * (c * c - s * s), 2.0 * gap * c * s
    extent = np.stack([np.stack([both + cosine, sine], -1), np.stack([sine, both - cosine], -1)], -2)
    return Seen(place, radius, np.maximum(along, distance * turned), near + moved, sigma_near, extent, length)
