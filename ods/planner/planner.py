"""The reference planner: way-points, obstacle lists and clearance in, set points of heading, speed and depth out.

Sampled-heading velocity obstacles (Kuwata and others, Safe maritime autonomous navigation with COLREGS, 2014) for a
vehicle that must keep forward speed and turns at a limited rate. It knows nothing but lists, clearances and its own set
points: no sonar, no truth, no map.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.geometry import wrap_angle
from ods.messages import Clearance, ObstacleList, Vector3
from ods.planner.conflict import conflict
from ods.planner.paths import Motion, Paths, paths_of
from ods.planner.settings import SteeringSettings
from ods.planner.unknown import unknown_m

CONFLICT_M = 100.0
"""What 1 m^2 s of conflict is worth, m of way: no detour is worth one."""
UNKNOWN_M = 1.0
"""What 1 m through water not known to be empty is worth, m of way."""
CHANGE_M = 0.5
"""What a change of the set heading by 1 rad is worth, m of way: else it sways between two ways round."""
BEYOND = 1.0
"""Paths are judged by their distance to a point on the straight way, at this multiple of their length."""
DRIFT_S = 10.0
"""The water's velocity is a mean over about this time."""


class SetPoint(NamedTuple):
    """Set point of the vehicle, until the next one."""

    heading_rad: float
    """From north to east."""
    speed_m_s: float
    """Through the water."""
    down_m: float
    avoiding: bool = False
    """Something is in the way."""
    valid: bool = True
    """The list can be relied on."""
    arrived: bool = False
    """The last way-point is reached."""


class Planner:
    """Goes from way-point to way-point."""

    def __init__(self, settings: SteeringSettings, way_points: Sequence[Vector3], heading_rad: float = 0.0) -> None:
        """`way_points`: north, east, down, m; `heading_rad`: the vehicle's at first."""
        self.settings = settings
        self._ahead = list(way_points)
        self._last = SetPoint(heading_rad, settings.slow_m_s, way_points[0][2], valid=False)
        self._heading_rad, self._speed = heading_rad, settings.slow_m_s
        self._drift = np.zeros(2)
        self._list: ObstacleList | None = None
        """The newest list that has the vehicle's pose."""
        self._clearance: Clearance | None = None
        self._valid_ns: int | None = None
        """Of the newest valid list; before there is one, of the first list."""
        self._steered_ns: int | None = None
        self._came_from_rad: float | None = None
        """Back to there, while the list is not valid; None: it is."""

    def receive(self, latest: ObstacleList, clearance: Clearance | None) -> None:
        """Receive a list and its clearance."""
        if latest.pose is not None:
            self._list = latest
            if latest.valid or self._valid_ns is None:
                self._valid_ns = latest.t_ns
        self._clearance = clearance

    def steer(self, now_ns: int) -> SetPoint:
        """Return what to do from now on; `now_ns`: of the same clock as the lists' `t_ns`."""
        elapsed_s = 0.0 if self._steered_ns is None else (now_ns - self._steered_ns) / NS
        self._steered_ns = now_ns
        change = self.settings.acceleration_m_s2 * elapsed_s
        self._speed += min(max(self._last.speed_m_s - self._speed, -change), change)
        if self._list is not None:
            self._last = self._next(self._list, now_ns, elapsed_s)
        return self._last

    def direct(self, now_ns: int) -> Paths:
        """Return the one path straight to the way-point: what would be done with nothing in the way."""
        assert self._list is not None
        now = self._motion(self._list, now_ns)
        heading = np.array([self._bearing(now)])
        return paths_of(now, heading, self.settings.cruise_m_s, self.settings, self._until_s(now))

    def _next(self, latest: ObstacleList, now_ns: int, elapsed_s: float) -> SetPoint:
        settings = self.settings
        self._follow_drift(latest, elapsed_s)
        now = self._motion(latest, now_ns)
        arrived = self._passed(now)
        assert self._valid_ns is not None
        since_s = (now_ns - self._valid_ns) / NS
        valid = latest.valid and since_s <= settings.stale_s
        if valid:
            self._came_from_rad = None
        elif self._came_from_rad is None:
            self._came_from_rad = now.heading_rad + math.pi
        desperate = not valid and since_s > settings.not_valid_after_s
        back = self._came_from_rad if desperate and settings.not_valid == "turn" else None
        heading, speed, avoiding = self._course(now, latest, now_ns, back)
        if not valid:
            speed = settings.slow_m_s
        down = self._ahead[0][2]
        if desperate and settings.not_valid == "climb":
            down = min(down, settings.climb_to_m)
        return SetPoint(heading, speed, down, avoiding, valid, arrived)

    def _course(self, now: Motion, latest: ObstacleList, now_ns: int, back: float | None) -> tuple[float, float, bool]:
        """Return the best heading and speed, and whether something is in the way."""
        settings, age_s = self.settings, (now_ns - latest.t_ns) / NS
        wanted = self._bearing(now) if back is None else back
        around = np.arange(settings.headings) * (2.0 * math.pi / settings.headings)
        headings = wrap_angle(wanted + around)
        best: tuple[float, float, float] = math.inf, wanted, settings.slow_m_s
        """Cost, heading, speed."""
        avoiding = False
        for speed in (settings.cruise_m_s, settings.slow_m_s):
            paths = paths_of(now, headings, speed, settings, self._until_s(now))
            bad = conflict(paths, latest.obstacles, age_s, settings)
            unknown = unknown_m(paths.places, self._clearance, settings.look_m)
            cost = CONFLICT_M * bad + UNKNOWN_M * unknown + self._way(paths, now, back)
            cost += CHANGE_M * np.abs(wrap_angle(headings - self._last.heading_rad))
            which = int(np.argmin(cost))
            if cost[which] < best[0]:
                known = unknown[which] < 0.5 * settings.look_m
                best = float(cost[which]), float(headings[which]), speed if known else settings.slow_m_s
            avoiding = avoiding or bool(bad[0] > 0.0)
            if bad[which] == 0.0:
                break
        return *best[1:], avoiding

    def _way(self, paths: Paths, now: Motion, back: float | None) -> Floats:
        """Return (n,) how far from where it wants to go each path leaves the vehicle, m: the mean over its time."""
        far = BEYOND * self.settings.cruise_m_s * self.settings.horizon_s
        way = np.array(self._ahead[0][:2]) - now.place
        if back is not None:
            way = far * np.array([math.cos(back), math.sin(back)])
        offset = paths.places - (now.place + way * (far / max(float(np.hypot(*way)), far)))
        away_m = np.sqrt(np.square(offset[..., 0]) + np.square(offset[..., 1]))
        return np.asarray(away_m @ paths.step_s / paths.t_s[-1])

    def _motion(self, latest: ObstacleList, now_ns: int) -> Motion:
        assert latest.pose is not None
        velocity = np.array(latest.pose.velocity_ned[:2])
        place = np.array(latest.pose.position_ned[:2]) + velocity * ((now_ns - latest.t_ns) / NS)
        return Motion(place, _heading_of(latest), self._speed, self._drift)

    def _follow_drift(self, latest: ObstacleList, elapsed_s: float) -> None:
        assert latest.pose is not None
        heading = _heading_of(latest)
        through = self._speed * np.array([math.cos(heading), math.sin(heading)])
        seen = np.array(latest.pose.velocity_ned[:2]) - through
        self._drift = self._drift + min(1.0, elapsed_s / DRIFT_S) * (seen - self._drift)

    def _bearing(self, now: Motion) -> float:
        """Return the heading that leads to the way-point in this drift."""
        north, east = (np.array(self._ahead[0][:2]) - now.place).tolist()
        bearing = math.atan2(east, north)
        across = float(now.drift[1] * math.cos(bearing) - now.drift[0] * math.sin(bearing))
        return bearing - math.asin(min(1.0, max(-1.0, across / self.settings.cruise_m_s)))

    def _until_s(self, now: Motion) -> float:
        """Return the time to look ahead, s: obstacles behind the last way-point do not count."""
        if len(self._ahead) > 1:
            return math.inf
        away = math.hypot(*(np.array(self._ahead[0][:2]) - now.place).tolist())
        return max(self.settings.certain_s, away / self.settings.slow_m_s)

    def _passed(self, now: Motion) -> bool:
        """Go on to the next way-point where one is reached; return whether the last one is."""
        north, east = (np.array(self._ahead[0][:2]) - now.place).tolist()
        if math.hypot(north, east) > self.settings.reached_m:
            return False
        if len(self._ahead) == 1:
            return True
        del self._ahead[0]
        return False


def _heading_of(latest: ObstacleList) -> float:
    assert latest.pose is not None
    w, x, y, z = latest.pose.attitude
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
