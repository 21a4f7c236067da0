"""Conflicts of candidate paths with listed obstacles: velocity obstacles with a chance constraint."""

import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.messages import Obstacle
from ods.planner.paths import Paths
from ods.planner.settings import SteeringSettings

HIT = 100.0
"""Factor by which a path through an obstacle is worse than one too near to it."""
LIKELIEST = 0.999999
NORMAL = NormalDist()
FAR_S = 1000.0
"""Beyond every horizon."""


class _Courses(NamedTuple):
    """Obstacles at the instants of the paths."""

    places: Floats
    """(k, m, 2) north, east, m."""
    radius_m: Floats
    """(k,) with the vehicle's."""
    spread_m: Floats
    """(k, m) to add, so that the risk is kept, m."""


def conflict(paths: Paths, obstacles: Sequence[Obstacle], age_s: float, settings: SteeringSettings) -> Floats:
    """Return (n,) how badly each path comes nearer to obstacles than it should; 0: it does not.

    The integral over time of the squared lack of distance, m^2 s. With existence p, an obstacle is kept off by z
    standard deviations more than `keep_m`, where p (1 - Phi(z)) is the risk; one that is less likely to be in the way
    than the risk needs no distance, nor does one that an operator said to ignore. `age_s`: time since the list's
    `t_ns`.
    """
    courses = _courses(obstacles, paths, age_s, settings)
    if not len(courses.places):
        return np.zeros(len(paths.heading_rad))
    bad = np.empty(len(paths.heading_rad))
    native.conflict(paths.places, paths.step_s, courses, settings.keep_m, HIT, bad)
    return bad


def _courses(obstacles: Sequence[Obstacle], paths: Paths, age_s: float, settings: SteeringSettings) -> _Courses:
    lead_s, fades_s = paths.t_s + age_s, settings.expected_s - settings.certain_s
    share = np.clip((settings.expected_s - paths.t_s) / fades_s, 0.0, 1.0)
    north_m, east_m = paths.start.tolist()
    reach_m = paths.reach_m + settings.keep_m + settings.vehicle_radius_m
    rows, sigma_m = [], []
    for each in obstacles:
        likely = each.existence * (1.0 - each.bottom_probability)
        if each.state == "terminated" or each.ignored_by >= 0 or likely <= settings.risk:
            continue
        sigmas = max(0.0, NORMAL.inv_cdf(1.0 - settings.risk / min(likely, LIKELIEST)))
        own_m = each.radius_m + math.hypot(*each.velocity_ned[:2]) * lead_s[-1]
        own_m += sigmas * math.hypot(_most_sigma_m(each, settings.expected_s + age_s), each.sigma_radius)
        if math.hypot(each.position_ned[0] - north_m, each.position_ned[1] - east_m) > reach_m + own_m:
            continue  # no path comes near it: what follows costs more
        rows.append((*each.position_ned[:2], *each.velocity_ned[:2], each.radius_m, each.sigma_radius, sigmas))
        sigma_m.append(_sigma_m(each, lead_s))
    north, east, v_north, v_east, radius, sigma_radius, sigmas_ = np.array(rows).reshape(-1, 7, 1).transpose(1, 0, 2)
    places = np.stack([north + lead_s * v_north, east + lead_s * v_east], axis=-1)
    sigma = np.hypot(np.array(sigma_m).reshape(-1, len(lead_s)), sigma_radius)
    return _Courses(places, radius[:, 0] + settings.vehicle_radius_m, sigmas_ * share * sigma)


def _most_sigma_m(obstacle: Obstacle, until_s: float) -> float:
    """Return what `_sigma_m` is not above until then, m."""
    last = obstacle.predicted[-1] if obstacle.predicted else None
    grown = 0.0 if last is not None and last.lead_s >= until_s else max(obstacle.sigma_velocity[:2]) * until_s
    at_last = 0.0 if last is None else max(last.sigma_position[:2])
    return max(math.hypot(*obstacle.sigma_position[:2]), at_last) + grown


def _sigma_m(obstacle: Obstacle, lead_s: Floats) -> Floats:
    """Return the (m,) longest half-axis of the error ellipse, m, as predicted; beyond that it grows as last."""
    north, east = obstacle.sigma_position[:2]
    now = math.sqrt(0.5 * (north**2 + east**2) + math.hypot(0.5 * (north**2 - east**2), obstacle.covariance_ne))
    leads, sigmas = [0.0], [now]
    for predicted in obstacle.predicted:
        if predicted.lead_s > leads[-1]:
            leads.append(predicted.lead_s)
            sigmas.append(max(predicted.sigma_position[:2]))
    growth = max(obstacle.sigma_velocity[:2])
    if len(leads) > 1:
        growth = max(0.0, (sigmas[-1] - sigmas[-2]) / (leads[-1] - leads[-2]))
    far_s = leads[-1] + FAR_S
    return np.interp(lead_s, [*leads, far_s], [*sigmas, sigmas[-1] + growth * FAR_S])
