"""Obstacles at another time: each extrapolated at its velocity, with the covariance of its position then."""

import math
from typing import NamedTuple

from ods.base.clock import NS
from ods.messages import Obstacle, ObstacleList, Vector3

Matrix3 = tuple[Vector3, Vector3, Vector3]


class ExtrapolatedObstacle(NamedTuple):
    """An obstacle at another time than that of its list."""

    obstacle: Obstacle
    """As it is in the list."""
    position_ned: Vector3
    covariance: Matrix3
    """Of that place, m^2, rows and columns north east down."""


def at(obstacle_list: ObstacleList, t_ns: int) -> list[ExtrapolatedObstacle]:
    """Return where the obstacles of a list, but those that ended, are at `t_ns`, on the clock of `obstacle_list.t_ns`.

    On another machine, where only UTC means anything: obstacle_list.t_ns + (utc_ns - obstacle_list.utc_ns).
    """
    lead_s = (t_ns - obstacle_list.t_ns) / NS
    return [extrapolated(each, lead_s) for each in obstacle_list.obstacles if each.state != "terminated"]


def extrapolated(obstacle: Obstacle, lead_s: float) -> ExtrapolatedObstacle:
    """Return an obstacle `lead_s` after its list; before it, if that is below 0.

    Errors of place and velocity are taken to go together, as in the list's own predictions; what manoeuvres add is
    that of these predictions.
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
    """Return the standard deviation of the place along a horizontal direction; the largest for (0, 0)."""
    (nn, ne, _), (_, ee, _), _ = ahead.covariance
    squared = north * north + east * east
    if squared < 1e-12:
        return math.sqrt(max(nn, ee))
    return math.sqrt(max(0.0, (north * north * nn + east * east * ee + 2.0 * north * east * ne) / squared))


def _by_manoeuvres(obstacle: Obstacle, axis: int, long_s: float) -> float:
    """Return what manoeuvres add to a variance in `long_s`, m^2, by what the predictions say.

    It grows faster than time, so a chord between two predictions lies above it; and never faster than time cubed.
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
