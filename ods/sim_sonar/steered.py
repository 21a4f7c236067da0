"""A simulated vehicle that obeys set points: surge, yaw and depth, with limits, in a current. No input or output."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames.quaternion import Quaternion, Vector3, from_euler
from ods.sim_sonar.pose import Times
from ods.sim_sonar.settings import VehicleSettings

YAW_S, DEPTH_S = 1.0, 2.0
"""Time constants of the autopilot's heading and depth loops, s."""
KEPT = 32
"""Number of states searched for an instant: a ping receives for fewer steps."""


class VehicleState(NamedTuple):
    """Where it is and how it moves."""

    t_s: float
    north_m: float
    east_m: float
    down_m: float
    heading_rad: float
    """From north to east; it goes on beyond a full turn."""
    speed_m_s: float
    """Through the water."""
    turn_rad_s: float
    climb_m_s: float
    """Vertical speed, upwards."""
    velocity_m_s: tuple[float, float]
    """Velocity over ground, north and east."""

    @property
    def place(self) -> Vector3:
        """NED, m."""
        return self.north_m, self.east_m, self.down_m

    @property
    def velocity_ned(self) -> Vector3:
        """m/s over ground."""
        return *self.velocity_m_s, -self.climb_m_s

    @property
    def attitude(self) -> Quaternion:
        """Body to global: level, along the heading."""
        return from_euler(0.0, 0.0, self.heading_rad)


def at_start(heading_rad: float, speed_m_s: float, place: Vector3 = (0.0, 0.0, 0.0)) -> VehicleState:
    """Return a vehicle at time 0 that goes straight on."""
    flat = speed_m_s * math.cos(heading_rad), speed_m_s * math.sin(heading_rad)
    return VehicleState(0.0, *place, heading_rad, speed_m_s, 0.0, 0.0, flat)


class SteeredVehicle:
    """Goes as its set points say, and remembers its way: a `Moving` for times around its newest ones.

    The current moves it, too: (north, east), m/s. One thread may step it while others ask where it is.
    """

    def __init__(
        self,
        settings: VehicleSettings,
        start: VehicleState,
        current_m_s: tuple[float, float] = (0.0, 0.0),
        kept: int = KEPT,
    ) -> None:
        """`kept`: states that are looked at for a place in time."""
        self._settings = settings
        self._current = current_m_s
        self.way = [start]
        """All states so far, in order of time."""
        before_s = np.arange(kept - 1, -1, -1.0)
        self._recent = np.repeat(np.array([start[:5]]), kept, axis=0)
        """(kept, 5) the newest ones; before the start it went straight on. Replaced at each step, never changed."""
        self._recent[:, 0] -= before_s
        self._recent[:, 1:3] -= np.multiply.outer(before_s, np.add(start.velocity_m_s, current_m_s))
        self.heading_rad, self.speed_m_s, self.down_m = start.heading_rad, start.speed_m_s, start.down_m
        """The set points."""
        self.stopped = False
        """Its propeller stands still."""

    def obey(self, heading_rad: float, speed_m_s: float, down_m: float) -> None:
        """Take new set points: heading, speed through the water, depth."""
        self.heading_rad, self.speed_m_s, self.down_m = heading_rad, speed_m_s, down_m
        self.stopped = False

    def stop(self) -> None:
        """Lose way until the next set points; heading and depth are kept, as far as it goes."""
        self.stopped = True

    def step(self, dt_s: float) -> VehicleState:
        """Go on by a time."""
        can, was = self._settings, self.way[-1]
        wanted = 0.0 if self.stopped else min(max(self.speed_m_s, can.least_m_s), can.most_m_s)
        speed = was.speed_m_s + _within(wanted - was.speed_m_s, can.acceleration_m_s2 * dt_s)
        off = math.remainder(self.heading_rad - was.heading_rad, 2.0 * math.pi)
        rate = _within(off / YAW_S, math.radians(can.turn_rate_deg_s))
        turn = was.turn_rad_s + _within(rate - was.turn_rad_s, math.radians(can.turn_acceleration_deg_s2) * dt_s)
        climb = _within((was.down_m - self.down_m) / DEPTH_S, can.climb_m_s)
        middle = was.heading_rad + 0.5 * turn * dt_s
        north, east = speed * math.cos(middle) + self._current[0], speed * math.sin(middle) + self._current[1]
        now = VehicleState(
            was.t_s + dt_s,
            was.north_m + north * dt_s,
            was.east_m + east * dt_s,
            was.down_m - climb * dt_s,
            was.heading_rad + turn * dt_s,
            speed,
            turn,
            climb,
            (north, east),
        )
        self.way.append(now)
        self._recent = np.concatenate([self._recent[1:], np.array([now[:5]])])
        return now

    def position(self, t_s: Times) -> Floats:
        """Return (..., 3) NED, m, at times (...)."""
        return np.ascontiguousarray(self._at(t_s)[0][..., :3])

    def velocity(self, t_s: Times) -> Floats:
        """Return (..., 3) NED over ground, m/s."""
        return np.ascontiguousarray(self._at(t_s)[1][..., :3])

    def attitude(self, t_s: Times) -> Floats:
        """Return (..., 4) unit quaternions, body to global: level, along the heading."""
        half = 0.5 * self._at(t_s)[0][..., 3]
        attitude = np.zeros((*np.shape(half), 4))
        attitude[..., 0], attitude[..., 3] = np.cos(half), np.sin(half)
        return attitude

    def _at(self, t_s: Times) -> tuple[Floats, Floats]:
        """Return (..., 4) north, east, down, heading, and how fast they change; straight on beyond both ends."""
        recent = self._recent
        times, rows = recent[:, 0], recent[:, 1:]
        before = np.minimum(np.maximum(times.searchsorted(t_s, side="right") - 1, 0), len(recent) - 2)
        slope = (rows[before + 1] - rows[before]) / (times[before + 1] - times[before])[..., None]
        return np.asarray(rows[before] + (t_s - times[before])[..., None] * slope), slope


def _within(value: float, most: float) -> float:
    return min(max(value, -most), most)
