"""Obstacles at another time, extrapolated with their velocities, with covariances."""

import math
from typing import NamedTuple

from ods.base.clock import NS
from ods.messages import Obstacle, ObstacleList, Vector3

Matrix3 = tuple[Vector3, Vector3, Vector3]


class ExtrapolatedObstacle(NamedTuple):
    """An obstacle extrapolated to another time than that of its list."""

    obstacle: Obstacle
    """As in the list."""
    position_ned: Vector3
    covariance: Matrix3
    """Of `position_ned`, m^2, rows and columns north, east, down."""


def at(obstacle_list: ObstacleList, t_ns: int) -> list[ExtrapolatedObstacle]:
    """Return a list's obstacles, except terminated ones, extrapolated to `t_ns` on the clock of `obstacle_list.t_ns`.

    For a UTC instant, for example on another computer, use t_ns = obstacle_list.t_ns + (utc_ns - obstacle_list.utc_ns).
    """
    lead_s = (t_ns - obstacle_list.t_ns) / NS
    return [extrapolated(each, lead_s) for each in obstacle_list.obstacles if each.state != "terminated"]


def extrapolated(obstacle: Obstacle, lead_s: float) -> ExtrapolatedObstacle:
    """Return an obstacle extrapolated to `lead_s` after its list; before it, if negative.

    Errors of position and velocity are assumed to be fully correlated, as in the list's predictions, from which the
    effect of manoeuvres is interpolated.
    """
    long_s = abs(lead_s)
    north, east, down = (p + v * lead_s for p, v in zip(obstacle.position_ned, obstacle.velocity_ned, strict=True))
    variances = [
        (s + v * long_s) ** 2 + _by_manoeuvres(obstacle, axis, long_s)
        for axis, (s, v) in enumerate(zip(obstacle.sigma_position, obstacle.sigma_velocity, strict=True))
    ]
    shared = obstacle.covariance_ne
    covariance = (variances[0], shared, 0.0), (shared, variances[1], 0.0), (0.0, 0.0, variances[2])
    return ExtrapolatedObstacle(obstacle, (north, east, down), covariance)


def spread_along(ahead: ExtrapolatedObstacle, north: float, east: float) -> float:
    """Return the standard deviation of the position along a horizontal direction; the larger one for (0, 0)."""
    (nn, ne, _), (_, ee, _), _ = ahead.covariance
    squared = north * north + east * east
    if squared < 1e-12:
        return math.sqrt(max(nn, ee))
    return math.sqrt(max(0.0, (north * north * nn + east * east * ee + 2.0 * north * east * ne) / squared))


def _by_manoeuvres(obstacle: Obstacle, axis: int, long_s: float) -> float:
    """Return the variance that manoeuvres add in `long_s`, m^2, interpolated between the list's predictions.

    It grows faster than time, so linear interpolation is an upper bound, and never faster than time cubed.
    """
    before_s = before = 0.0
    for each in obstacle.predicted:
        carried = obstacle.sigma_position[axis] + obstacle.sigma_velocity[axis] * each.lead_s
        added = max(0.0, each.sigma_position[axis] ** 2 - carried**2)
        if long_s <= each.lead_s:
            share = (long_s - before_s) / (each.lead_s - before_s) if each.lead_s > before_s else 1.0
            return before + share * (added - before)
        before_s, before = each.lead_s, added
    return before * (long_s / before_s) ** 3 if before_s > 0.0 else 0.0
