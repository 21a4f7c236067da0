"""Reports of lists and clearance on the obstacle that the vehicle came nearest to, just before."""

import math
from typing import Literal, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.base.frames.quaternion import Quaternion
from ods.messages import Clearance, ObstacleList
from ods.missions.world import World
from ods.sim_sonar.steered import VehicleState

BEFORE_S = 5.0
"""Time before the closest approach, s: at a turn rate of 10 degrees a second there is little that helps later."""
LEAST_M = 1.0
"""Least radius of a listed circle, m."""

Warned = Literal["", "not valid", "caution", "unknown water"]


class _Said(NamedTuple):
    t_s: float
    valid: bool
    caution: bool
    covered: Mask
    """(n,) for each obstacle: a circle of the list covers it."""
    empty: Mask
    """(n,) for each obstacle: the water where it begins was reported as empty."""


class Witness:
    """Remembers the reports of each obstacle. Reported positions are relative to the vehicle's reported position."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._said: list[_Said] = []

    def receive(self, received: ObstacleList, clearance: Clearance | None, sent: VehicleState, t_s: float) -> None:
        """Record the planner's input at `t_s` for the ping `sent` from there."""
        covered, empty = self._covered(received, sent), self._called_empty(received, clearance, sent)
        self._said.append(_Said(t_s, received.valid, bool(received.caution), covered, empty))

    def before(self, t_s: float, which: int) -> tuple[bool, Warned]:
        """Return whether an obstacle was listed in the last BEFORE_S before `t_s`, and what warned of the list then."""
        said = [each for each in self._said if t_s - BEFORE_S <= each.t_s <= t_s]
        listed = any(each.covered[which] for each in said)
        if not said or not all(each.valid for each in said):
            return listed, "not valid"
        if any(each.caution for each in said):
            return listed, "caution"
        return listed, "" if any(each.empty[which] for each in said) else "unknown water"

    def _covered(self, received: ObstacleList, sent: VehicleState) -> Mask:
        radius = self._world.radius_m
        if not received.obstacles:
            return np.zeros(len(radius), np.bool_)
        listed = np.array([each.position_ned[:2] for each in received.obstacles])
        if received.pose is not None:
            turn = sent.heading_rad - _heading(received.pose.attitude)
            cos, sin = math.cos(turn), math.sin(turn)
            ahead = listed - received.pose.position_ned[:2]
            listed = ahead @ np.array([[cos, sin], [-sin, cos]]) + (sent.north_m, sent.east_m)
        off = np.hypot(*(self._world.places(sent.t_s)[:, None] - listed).transpose(2, 0, 1))
        over = np.array([max(each.radius_m, LEAST_M) for each in received.obstacles])
        return np.asarray((off < radius[:, None] + over).any(axis=1))

    def _called_empty(self, received: ObstacleList, clearance: Clearance | None, sent: VehicleState) -> Mask:
        north, east = (self._world.places(sent.t_s) - (sent.north_m, sent.east_m)).T
        if clearance is None or not clearance.valid:
            return np.zeros(len(north), np.bool_)
        turn = 0.0 if received.pose is None else _heading(received.pose.attitude) - sent.heading_rad
        sectors = len(clearance.clear_to_m)
        sector = np.floor(sectors * (np.arctan2(east, north) + turn) / (2.0 * math.pi)).astype(int) % sectors
        edge: Floats = np.hypot(north, east) - self._world.radius_m
        return np.asarray(
            (np.array(clearance.clear_from_m)[sector] <= edge) & (edge < np.array(clearance.clear_to_m)[sector])
        )


def _heading(attitude: Quaternion) -> float:
    w, x, y, z = attitude
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
