"""The paths that a vehicle may take: turn to a heading as fast as it can, then go straight on."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames.geometry import wrap_angle
from ods.planner.settings import SteeringSettings

FINE_S, FINE_UNTIL_S, COARSE_S = 0.5, 8.0, 2.0
"""Steps of time: fine ones as long as the vehicle may still turn."""


class Motion(NamedTuple):
    """The vehicle now."""

    place: Floats
    """(2,) north, east, m."""
    heading_rad: float
    speed_m_s: float
    """Through the water."""
    drift: Floats
    """(2,) velocity of the water, north, east, m/s."""


class Paths(NamedTuple):
    """One path for each of n headings, at m instants."""

    t_s: Floats
    """(m,) time from now."""
    step_s: Floats
    """(m,) time since the previous instant."""
    heading_rad: Floats
    """(n,) that each path ends with."""
    places: Floats
    """(n, m, 2) north, east, m."""
    start: Floats
    """(2,) common start of all paths."""
    reach_m: float
    """Largest distance of any path from the start."""


@lru_cache(maxsize=4)
def instants(horizon_s: float) -> Floats:
    """Return the (m,) instants at which paths are looked at, s. Do not write to it."""
    fine = np.arange(FINE_S, min(FINE_UNTIL_S, horizon_s) + 1e-9, FINE_S)
    return np.concatenate([fine, np.arange(FINE_UNTIL_S + COARSE_S, horizon_s + 1e-9, COARSE_S)])


def paths_of(
    now: Motion, heading_rad: Floats, speed_m_s: float, settings: SteeringSettings, until_s: float = math.inf
) -> Paths:
    """Return the paths to (n,) headings at a speed through the water, up to `until_s` or the horizon."""
    t_s = instants(min(until_s, settings.horizon_s))
    step_s = t_s - np.concatenate([[0.0], t_s[:-1]])
    middle = t_s - 0.5 * step_s
    turn = wrap_angle(heading_rad - now.heading_rad)
    most = settings.turn_rate_rad_s * middle
    course = now.heading_rad + np.minimum(np.maximum(turn[:, None], -most), most)
    change = settings.acceleration_m_s2 * middle
    speed = now.speed_m_s + np.minimum(np.maximum(speed_m_s - now.speed_m_s, -change), change)
    step_m = speed * step_s
    places = np.empty((*course.shape, 2))
    for axis, share in enumerate((np.cos(course), np.sin(course))):
        places[:, :, axis] = now.place[axis] + now.drift[axis] * t_s + np.cumsum(share * step_m, axis=1)
    reach_m = float(np.abs(step_m).sum()) + math.hypot(*now.drift.tolist()) * float(t_s[-1])
    return Paths(t_s, step_s, heading_rad, places, now.place, reach_m)
