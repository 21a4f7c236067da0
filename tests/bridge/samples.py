"""A list with one rock, one swimmer and what has ended, and the vehicle's pose, with numbers to compute by hand."""

import math
from typing import Any

from ods.base.clock import NS
from ods.base.geodesy import SiteSettings
from ods.bridge.moment import Moment
from ods.messages import ClosestApproach, Obstacle, ObstacleList, Pose

SITE = SiteSettings(latitude_deg=57.0, longitude_deg=10.0)
T_NS = 1_000 * NS
UTC_NS = 1_767_323_045_500_000_000
"""2026-01-02 03:04:05.5."""
EAST = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""Heading 90 deg."""


def obstacle(number: int, north: float, east: float, **more: Any) -> Obstacle:
    values: dict[str, Any] = {
        "id": number, "state": "active", "position_ned": (north, east, 5.0), "velocity_ned": (0.0, 0.0, 0.0),
        "radius_m": 2.0, "sigma_position": (0.3, 0.4, 3.0), "sigma_velocity": (0.1, 0.1, 0.1), "sigma_radius": 0.0,
        "first_seen_utc_ns": UTC_NS, "last_seen_utc_ns": UTC_NS, "times_seen": 9, "existence": 0.99,
    }  # fmt: skip
    return Obstacle(**(values | more))


ROCK = obstacle(7, 100.0, 50.0, cpa=ClosestApproach(time_s=61.0, distance_m=18.52, sigma_m=0.5))
SWIMMER = obstacle(300, 110.0, 90.0, velocity_ned=(0.0, -2.0, 0.0))
"""To the west at 2 m/s."""
ENDED = obstacle(8, 100.0, 21.0, state="terminated")


def pose(t_ns: int = T_NS + NS // 2, **more: Any) -> Pose:
    """Return one at 100 m north, 20 m east, that goes to the east at 2 m/s, a half second after the list."""
    values: dict[str, Any] = {
        "seq": 0, "t_ns": t_ns, "utc_ns": UTC_NS, "position_ned": (100.0, 20.0, 5.0), "attitude": EAST,
        "velocity_body": (2.0, 0.0, 0.0), "sigma_position_ned": (0.1, 0.1, 0.1), "sigma_attitude": (0.01, 0.01, 0.01),
    }  # fmt: skip
    return Pose(**(values | more))


def picture(*obstacles: Obstacle, t_ns: int = T_NS, **more: Any) -> ObstacleList:
    values: dict[str, Any] = {
        "seq": 3, "ping_number": 5, "t_ns": t_ns, "utc_ns": UTC_NS, "t_rx_ns": t_ns, "valid": True, "reasons": [],
        "obstacles": list(obstacles), "utc_source": "ins", "made_ns": t_ns,
    }  # fmt: skip
    return ObstacleList(**(values | more))


def moment(*obstacles: Obstacle, **more: Any) -> Moment:
    """Return a list that is sent one second after its ping: the vehicle is at 21 m east by then."""
    return Moment(picture(*obstacles, **more), pose(), T_NS + NS, SITE)
