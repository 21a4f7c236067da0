"""A list with one rock, one swimmer and what has ended, and the vehicle's pose, with numbers to compute by hand."""

import math
from typing import Any

from ods.base import clock
from ods.base.clock import NS
from ods.bridge.extrapolated_list import ExtrapolatedList
from ods.messages import Clearance, ClosestApproach, Obstacle, ObstacleList, Ping, PoseAt, Site

SITE = Site(latitude_deg=57.0, longitude_deg=10.0)
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


POSE = PoseAt((100.0, 19.0, 5.0), EAST, (0.0, 2.0, 0.0), (0.1, 0.1, 0.1), (0.01, 0.01, 0.01))
"""At 100 m north, 19 m east; goes to the east at 2 m/s."""


def obstacle_list(*obstacles: Obstacle, t_ns: int = T_NS, **more: Any) -> ObstacleList:
    values: dict[str, Any] = {
        "seq": 3, "ping_number": 5, "t_ns": t_ns, "utc_ns": UTC_NS, "t_rx_ns": t_ns, "valid": True, "reasons": [],
        "obstacles": list(obstacles), "utc_source": "ins", "made_ns": t_ns, "site": SITE, "pose": POSE,
    }  # fmt: skip
    return ObstacleList(**(values | more))


def moment(*obstacles: Obstacle, **more: Any) -> ExtrapolatedList:
    """Return a list that is sent one second after its ping: the vehicle is at 21 m east by then."""
    return ExtrapolatedList(obstacle_list(*obstacles, **more), POSE, T_NS + NS)


def image(now_ns: int) -> Ping:
    """Return a ping of 64 beams and 200 samples."""
    return Ping(
        seq=0, ping_number=5, t_ns=now_ns, t_rx_ns=now_ns, utc_ns=clock.utc_ns(now_ns), beams=64, samples=200,
        dtype="u1", data=bytes(64 * 200), bearing_rad=[0.01 * beam for beam in range(64)], range0_m=0.5, dr_m=0.1,
        sound_speed=1500.0,
    )  # fmt: skip


def clearance(reported: ObstacleList, **more: Any) -> Clearance:
    """Return one of 72 sectors of which all are clear up to 500 m."""
    values: dict[str, Any] = {
        "seq": reported.seq, "ping_number": reported.ping_number, "t_ns": reported.t_ns, "utc_ns": reported.utc_ns,
        "valid": reported.valid, "clear_from_m": [0.0] * 72, "clear_to_m": [500.0] * 72, "nearest_m": [None] * 72,
        "pose": reported.pose,
    }  # fmt: skip
    return Clearance(**(values | more))
