"""Obstacle lists, clearances and a vehicle that follows the planner at once, for tests."""

import math
from typing import Any

from ods.base.clock import NS
from ods.base.frames.quaternion import from_euler
from ods.messages import Clearance, Obstacle, ObstacleList, PoseAt, Prediction
from ods.planner.planner import Planner, SetPoint

PERIOD_S = 0.2


def obstacle(north: float, east: float, radius_m: float = 1.0, **more: Any) -> Obstacle:
    fields: dict[str, Any] = {
        "id": 1,
        "state": "active",
        "velocity_ned": (0.0, 0.0, 0.0),
        "sigma_position": (0.1, 0.1, 0.1),
        "sigma_velocity": (0.0, 0.0, 0.0),
        "sigma_radius": 0.1,
        "first_seen_utc_ns": 0,
        "last_seen_utc_ns": 0,
        "times_seen": 10,
        "existence": 1.0,
    }
    return Obstacle(position_ned=(north, east, 20.0), radius_m=radius_m, **(fields | more))


def predicted(obstacle_: Obstacle, *sigmas: tuple[float, float]) -> list[Prediction]:
    """Return predictions of an obstacle at rest: (lead, standard deviation)."""
    return [Prediction(lead, obstacle_.position_ned, (sigma, sigma, sigma)) for lead, sigma in sigmas]


def pose(north: float, east: float, heading_rad: float = 0.0, speed: float = 2.0) -> PoseAt:
    velocity = speed * math.cos(heading_rad), speed * math.sin(heading_rad), 0.0
    zero = (0.0, 0.0, 0.0)
    return PoseAt((north, east, 20.0), from_euler(0.0, 0.0, heading_rad), velocity, zero, zero)


def reported(at: PoseAt, *obstacles: Obstacle, t_s: float = 0.0, valid: bool = True) -> ObstacleList:
    t_ns = round(t_s * NS)
    return ObstacleList(0, 0, t_ns, t_ns, t_ns, valid, [] if valid else ["silence"], list(obstacles), pose=at)


def clear(at: PoseAt, reach_m: float | list[float] = 100.0, *, sectors: int = 72, valid: bool = True) -> Clearance:
    reach = reach_m if isinstance(reach_m, list) else [reach_m] * sectors
    return Clearance(0, 0, 0, 0, valid, [0.0] * len(reach), reach, [None] * len(reach), pose=at)


def steered(planner: Planner, *obstacles: Obstacle, speed: float = 2.0) -> SetPoint:
    """Return what it does about obstacles, of a vehicle at the origin that goes north."""
    here = pose(0.0, 0.0, speed=speed)
    planner.receive(reported(here, *obstacles), clear(here))
    return planner.steer(0)
