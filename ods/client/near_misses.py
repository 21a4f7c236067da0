"""Near misses: obstacles that may come near within a horizon, if the vehicle keeps its velocity."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from ods.base.clock import NS
from ods.client.extrapolation import extrapolated, spread_along
from ods.messages import Obstacle, ObstacleList, PoseAt

TRUSTED_AHEAD = 10.0
"""Longest extrapolation of a velocity, in multiples of the time for which the object has been observed: after half a
second static and moving objects cannot be distinguished, and two standard deviations of a velocity reach everywhere."""
STEP_S = 1.0
"""Between the times checked; the closest approach is always one of them."""


class NearMiss(NamedTuple):
    """An obstacle that may come near."""

    obstacle: Obstacle
    time_s: float
    """When it may first be nearer than `within_m`, after the list's `t_ns`."""
    distance_m: float
    """From the vehicle's origin to the obstacle's edge when it may be nearest; below 0: inside it."""
    sigma_m: float
    """Standard deviation of `distance_m`."""


def near_misses(
    obstacle_list: ObstacleList, within_m: float, horizon_s: float = 60.0, sigmas: float = 2.0
) -> list[NearMiss]:
    """Return which obstacles may come within `within_m` of the vehicle's origin in the next `horizon_s`, soonest first.

    An obstacle may come that near if it does so within `sigmas` standard deviations of position and radius. Distances
    are horizontal, because depths are hardly observable. Without the vehicle's pose every obstacle is returned, with
    time 0. Obstacles that an operator has vetoed (`Obstacle.ignored_by`) are omitted. A list that is not valid may lack
    obstacles: see `valid`.
    """
    present = [each for each in obstacle_list.obstacles if each.state != "terminated" and each.ignored_by < 0]
    vehicle = obstacle_list.pose
    if vehicle is None:
        return [NearMiss(each, 0.0, 0.0, 0.0) for each in present]
    found = [_near_miss(each, vehicle, within_m, horizon_s, sigmas) for each in present]
    return sorted((each for each in found if each is not None), key=lambda each: each.time_s)


class _Moment(NamedTuple):
    time_s: float
    distance_m: float
    sigma_m: float


def _near_miss(
    obstacle: Obstacle, vehicle: PoseAt, within_m: float, horizon_s: float, sigmas: float
) -> NearMiss | None:
    trusted_s = min(horizon_s, TRUSTED_AHEAD * (obstacle.last_seen_utc_ns - obstacle.first_seen_utc_ns) / NS)
    trusted_s = max(trusted_s, 0.0)
    now = _moment(obstacle, vehicle, 0.0, trusted_s)
    farthest = extrapolated(obstacle, trusted_s).covariance
    spread = math.sqrt(farthest[0][0] + farthest[1][1] + obstacle.sigma_radius**2)
    reach = math.hypot(*obstacle.velocity_ned[:2]) * trusted_s + math.hypot(*vehicle.velocity_ned[:2]) * horizon_s
    if now.distance_m - reach - sigmas * spread >= within_m:
        return None
    moments = [_moment(obstacle, vehicle, t, trusted_s) for t in _times(obstacle, vehicle, horizon_s, trusted_s)]
    near = [each for each in moments if each.distance_m - sigmas * each.sigma_m < within_m]
    if not near:
        return None
    nearest = min(near, key=lambda each: each.distance_m - sigmas * each.sigma_m)
    return NearMiss(obstacle, near[0].time_s, nearest.distance_m, nearest.sigma_m)


def _moment(obstacle: Obstacle, vehicle: PoseAt, time_s: float, trusted_s: float) -> _Moment:
    """Return an obstacle's distance at a time; after `trusted_s` it is assumed not to move."""
    there = extrapolated(obstacle, min(time_s, trusted_s))
    north, east = (
        there.position_ned[axis] - vehicle.position_ned[axis] - vehicle.velocity_ned[axis] * time_s for axis in (0, 1)
    )
    sigma = math.hypot(spread_along(there, north, east), obstacle.sigma_radius)
    return _Moment(time_s, math.hypot(north, east) - obstacle.radius_m, sigma)


def _times(obstacle: Obstacle, vehicle: PoseAt, horizon_s: float, trusted_s: float) -> list[float]:
    """Return the times to check, in order."""
    steps = math.ceil(horizon_s / STEP_S)
    regular = [horizon_s * k / steps for k in range(steps + 1)] if steps else [0.0]
    return sorted({*regular, trusted_s, *_closest(obstacle, vehicle, horizon_s, trusted_s)})


def _closest(obstacle: Obstacle, vehicle: PoseAt, horizon_s: float, trusted_s: float) -> Iterator[float]:
    """Yield the time of the closest approach while the obstacle is extrapolated, and after."""
    offset = [obstacle.position_ned[axis] - vehicle.position_ned[axis] for axis in (0, 1)]
    moving, own = obstacle.velocity_ned, vehicle.velocity_ned
    drift = [moving[axis] - own[axis] for axis in (0, 1)]
    yield _nearest(offset, drift, 0.0, trusted_s)
    stopped = [offset[axis] + moving[axis] * trusted_s for axis in (0, 1)]
    yield _nearest(stopped, [-own[0], -own[1]], trusted_s, horizon_s)


def _nearest(offset: list[float], drift: list[float], first_s: float, last_s: float) -> float:
    speed_2 = drift[0] ** 2 + drift[1] ** 2
    time_s = -(offset[0] * drift[0] + offset[1] * drift[1]) / speed_2 if speed_2 > 0.0 else first_s
    return min(max(time_s, first_s), last_s)
