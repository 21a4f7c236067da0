"""A range image of the Sonar 3D-15 as a ping: directions, ranges, numbers that make sense. Pure."""

import math
from functools import lru_cache

import numpy as np

from ods.messages import Ping, RangeGrid
from ods.sonar_link.ping_builder import BeamTable, Geometry, Stamp, build_range_ping, make_beam_table
from ods.sonar_link.sonar3d15.packets import RangeImage
from ods.sonar_link.sonar3d15.unpack import pixels_of

MOST_SIDE = 1024
"""Pixels."""
LEAST_HZ = 1000
"""What is less is no frequency in Hz: the recordings of Water Linked have 5."""
LATEST_NS = 2**62


def ping_of(image: RangeImage, stamp: Stamp) -> Ping:
    """Return the ping of a range image. Raises ValueError when its numbers do not fit each other."""
    if not (2 <= image.width <= MOST_SIDE and 2 <= image.height <= MOST_SIDE):
        raise ValueError(f"image of {image.width} x {image.height} pixels")
    if not 0.0 < image.range_m < math.inf:
        raise ValueError(f"range: {image.range_m:g} m")
    geometry = Geometry(
        table=_beams(image.width, image.opening_deg),
        range0_m=0.0,
        dr_m=image.scale_m,
        sound_speed=image.sound_speed,
        frequency_hz=float(image.frequency) if image.frequency >= LEAST_HZ else 0.0,
    )
    grid = RangeGrid(_elevations(image.height, image.vertical_deg), image.range_m)
    return build_range_ping(pixels_of(image.packed, image.width, image.height), geometry, stamp, grid)


@lru_cache(maxsize=4)
def _beams(width: int, opening_deg: float) -> BeamTable:
    return make_beam_table(_angles(width, opening_deg, 180.0), np.zeros(width))


@lru_cache(maxsize=4)
def _elevations(height: int, vertical_deg: float) -> list[float]:
    return _angles(height, vertical_deg, 90.0)


def _angles(count: int, opening_deg: float, most_deg: float) -> list[float]:
    """Return the angles of pixels, evenly spaced, the outermost at the borders, rad."""
    if not 0.0 < opening_deg <= most_deg:
        raise ValueError(f"opening: {opening_deg:g} degrees")
    half = 0.5 * math.radians(opening_deg)
    return [*np.linspace(-half, half, count).tolist()]
