"""The path of an all-knowing planner on the bench, to which the vehicle's path is compared."""

import math
from itertools import pairwise

import numpy as np

from ods.base.arrays import Floats
from ods.bench.way.avoidance import Mission
from ods.messages import VehicleTruth
from ods.missions.all_knowing.search import PathQuery, fastest_path
from ods.sim_sonar.steered import VehicleState, at_start

STEP_S = 0.05
PATIENCE = 3.0
"""Longest duration of a way, in multiples of the straight one's at low speed."""


def best_path(mission: Mission, first: VehicleTruth) -> Floats | None:
    """Return the (k, 2) north, east of the fastest way from where the vehicle was first, m; None: none was found.

    Objects count as upright cylinders, and `keep_m` is kept from them. The depth is that of the start.
    """
    steering, at, legs = mission.steering, _state(mission, first), list[Floats]()
    radius_m = mission.scene.objects_at(first.scene_s).radius_m
    for point in mission.way_points:
        straight_m = math.dist(point[:2], (at.north_m, at.east_m))
        query = PathQuery(
            at, point[:2], steering.reached_m, lambda t_s: mission.scene.objects_at(t_s).position_ned[:, :2], radius_m,
            mission.keep_m + mission.can.radius_m, mission.can, (steering.cruise_m_s, steering.slow_m_s),
            mission.current_m_s, STEP_S, 1, PATIENCE * straight_m / steering.slow_m_s,
        )  # fmt: skip
        way = fastest_path(query)
        if way is None:
            return None
        legs.append(way.places)
        at = way.end
    return np.concatenate(legs)


def length_m(places: Floats) -> float:
    """Return the length of a way, (k, 2)."""
    return sum(math.dist(one, other) for one, other in pairwise(places.tolist()))


def _state(mission: Mission, first: VehicleTruth) -> VehicleState:
    w, x, y, z = first.attitude
    heading = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    north, east = np.subtract(first.velocity_ned[:2], mission.current_m_s).tolist()
    return at_start(heading, math.hypot(north, east), first.position_ned)._replace(t_s=first.scene_s)
