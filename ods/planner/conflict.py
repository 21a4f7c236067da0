"""By how much paths come too near to what is listed: velocity obstacles with a chance constraint."""

from collections.abc import Sequence
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.messages import Obstacle
from ods.planner.paths import Paths
from ods.planner.settings import SteeringSettings

HIT = 100.0
"""A path through an obstacle itself is so many times worse than one too near to it."""
LIKELIEST = 0.999999


class _Courses(NamedTuple):
    """Obstacles at the instants of the paths."""

    places: Floats
    """(k, m, 2) north, east, m."""
    radius_m: Floats
    """(k, 1)."""
    spread_m: Floats
    """(k, m) to add, so that the risk is kept."""


def conflict(paths: Paths, obstacles: Sequence[Obstacle], age_s: float, settings: SteeringSettings) -> Floats:
    """Return (n,) how badly each path comes nearer to obstacles than it should; 0: it does not.

    The integral over time of the squared lack of distance, m^2 s. With existence p, an obstacle is kept off by z
    standard deviations more than `keep_m`, where p (1 - Phi(z)) is the risk; one that is less likely to be in the way
    than the risk needs no distance. `age_s`: time since the list's `t_ns`.
    """
    told = _courses(obstacles, paths.t_s + age_s, age_s, settings)
    if not len(told.places):
        return np.zeros(len(paths.heading_rad))
    offset = paths.places[:, None] - told.places
    edge = np.sqrt(np.einsum("...i,...i", offset, offset)) - (told.radius_m + settings.vehicle_radius_m)
    lack = np.maximum(settings.keep_m + told.spread_m - edge, 0.0)
    badness = lack * lack * np.where(edge < 0.0, HIT, 1.0)
    return np.asarray(badness.max(axis=1) @ np.diff(paths.t_s, prepend=0.0))


def _courses(obstacles: Sequence[Obstacle], lead_s: Floats, age_s: float, settings: SteeringSettings) -> _Courses:
    share = np.clip((settings.horizon_s - (lead_s - age_s)) / (settings.horizon_s - settings.certain_s), 0.0, 1.0)
    places, radius, spread = [], [], []
    for each in obstacles:
        likely = each.existence * (1.0 - each.bottom_probability)
        if each.state == "terminated" or likely <= settings.risk:
            continue
        sigmas = max(0.0, NormalDist().inv_cdf(1.0 - settings.risk / min(likely, LIKELIEST)))
        place, velocity = np.array(each.position_ned[:2]), np.array(each.velocity_ned[:2])
        places.append(place + lead_s[:, None] * velocity)
        radius.append(each.radius_m)
        spread.append(sigmas * share * np.hypot(_sigma_m(each, lead_s), each.sigma_radius))
    count, instants = len(places), len(lead_s)
    return _Courses(
        np.array(places).reshape(count, instants, 2),
        np.array(radius).reshape(count, 1),
        np.array(spread).reshape(count, instants),
    )


def _sigma_m(obstacle: Obstacle, lead_s: Floats) -> Floats:
    """Return the (m,) longest half-axis of the error ellipse, m, as predicted; beyond that it grows as last."""
    north, east = obstacle.sigma_position[:2]
    between = obstacle.covariance_ne
    now = np.sqrt(0.5 * (north**2 + east**2) + np.hypot(0.5 * (north**2 - east**2), between))
    told = [(0.0, float(now))] + [(each.lead_s, max(each.sigma_position[:2])) for each in obstacle.predicted]
    known = dict(sorted(told))
    leads, sigmas = np.array(list(known)), np.array(list(known.values()))
    last = max(obstacle.sigma_velocity[:2]) if len(leads) == 1 else _slope(leads, sigmas)
    return np.asarray(np.interp(lead_s, leads, sigmas) + np.maximum(lead_s - leads[-1], 0.0) * last)


def _slope(leads: Floats, sigmas: Floats) -> float:
    return max(0.0, float((sigmas[-1] - sigmas[-2]) / (leads[-1] - leads[-2])))
