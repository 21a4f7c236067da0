"""Obstacles as GIVEN_OBSTACLE of MOOS-IvP, each in a datagram as pShare takes it.

Formats as read in moos-ivp a2a9b716c: CMOOSMsg::Serialize (little endian; texts by their length and bytes) and
pObstacleMgr's handleGivenObstacle, which wants a convex polygon and a duration of 60 s at most. MOOS's local frame has
x to the east and y to the north.
"""

import math
import struct

from ods.base.clock import NS
from ods.bridge.encoder import Encoded
from ods.bridge.extrapolated_list import ExtrapolatedList
from ods.bridge.settings import MoosSettings
from ods.messages import Obstacle, Outline

SOURCE = "ods"
CORNERS = 8
NO_NUMBER = -1.0
NO_ID = -1


class MoosEncoder:
    """Lists to datagrams for pShare."""

    def __init__(self, settings: MoosSettings) -> None:
        self._settings = settings

    def encode(self, extrapolated: ExtrapolatedList) -> Encoded:
        """Return a datagram for each obstacle that is not ignored, the nearest first."""
        nearest = extrapolated.nearest(self._settings.most_obstacles, ignored=False)
        utc_s = extrapolated.utc_ns / NS
        texts = (given_obstacle(obstacle, extrapolated, self._settings) for obstacle in nearest)
        return Encoded([message("GIVEN_OBSTACLE", text, utc_s) for text in texts], extrapolated.left_out(len(nearest)))


def given_obstacle(obstacle: Obstacle, extrapolated: ExtrapolatedList, settings: MoosSettings) -> str:
    """Return a polygon around an obstacle where it is now: an octagon whose sides touch the circle, or its strip."""
    sigma = settings.sigmas * math.hypot(obstacle.sigma_radius, _widest_sigma(obstacle))
    corners = _octagon(obstacle.radius_m + sigma) if obstacle.outline is None else _strip(obstacle.outline, sigma)
    centre = obstacle.position_ned[:2] if obstacle.outline is None else obstacle.outline.middle_ne
    place = extrapolated.place(obstacle)
    north, east = (at + now - then for at, now, then in zip(centre, place, obstacle.position_ned[:2], strict=False))
    points = ":".join(f"{east + y:.2f},{north + x:.2f}" for x, y in corners)
    return f"pts={{{points}}},label={SOURCE}_{obstacle.id},vsource={SOURCE},duration={settings.duration_s:g}"


def _octagon(radius_m: float) -> list[tuple[float, float]]:
    corner_m = radius_m / math.cos(math.pi / CORNERS)
    angles = [2.0 * math.pi * corner / CORNERS for corner in range(CORNERS)]
    return [(corner_m * math.sin(angle), corner_m * math.cos(angle)) for angle in angles]


def _strip(outline: Outline, wider_m: float) -> list[tuple[float, float]]:
    """Return the corners of an outline, `wider_m` wider on all sides, north and east from its middle."""
    long_m, wide_m = outline.half_length_m + wider_m, outline.half_width_m + wider_m
    c, s = math.cos(outline.azimuth_rad), math.sin(outline.azimuth_rad)
    signs = ((1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0))
    return [(a * long_m * c - b * wide_m * s, a * long_m * s + b * wide_m * c) for a, b in signs]


def _widest_sigma(obstacle: Obstacle) -> float:
    """Return the long half axis of the ellipse of one standard deviation, m: the root of the larger eigenvalue."""
    north, east = obstacle.sigma_position[0] ** 2, obstacle.sigma_position[1] ** 2
    return math.sqrt(0.5 * (north + east) + math.hypot(0.5 * (north - east), obstacle.covariance_ne))


def message(key: str, text: str, utc_s: float) -> bytes:
    """Return a notification of a text as pShare takes it: a serialised CMOOSMsg."""
    names = b"".join(map(_packed, (SOURCE, "", SOURCE, key)))
    body = struct.pack("<icc", NO_ID, b"N", b"S") + names
    body += struct.pack("<ddd", utc_s, NO_NUMBER, NO_NUMBER) + _packed(text)
    return struct.pack("<i", 4 + len(body)) + body


def _packed(text: str) -> bytes:
    data = text.encode()
    return struct.pack("<i", len(data)) + data
