"""The fastest way to a goal among obstacles that move as is known: A* over the vehicle's own motions.

Hybrid A* (Dolgov and others, Path planning for autonomous vehicles in unknown semi-structured environments, 2010) with
time in its states, as obstacles move. Each move is a set point held for about a second, and the vehicle's answer to it;
what is found can so be flown as it is.
"""

import heapq
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.missions.all_knowing.motions import Motions, VehicleCommands, motion_of, moved
from ods.sim_sonar.settings import VehicleSettings
from ods.sim_sonar.steered import YAW_S, VehicleState

MOVE_S = 1.0
"""Approximate duration of a move, s."""
TURNS = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Turn rates that are tried, shares of the highest."""
CELL_M, HEADINGS, SPEED_M_S, TIME_S = 1.0, 48, 0.5, 4.0
"""States are one where place, heading, speed and time fall into one cell."""
EAGER = 1.02
"""Factor on the time still needed: a way that is found is at most that much slower than the fastest."""
AT_ONCE = 64
"""States that are gone on from at a time."""
MOST_STATES = 150_000
"""Number of states after which the search ends without a way."""
CLOSER_M = 0.1
"""Kept beside the distance to keep, as places are looked at now and then only, m."""
LOOKS = 8
"""Places of a move at which distances are looked at."""


class PathQuery(NamedTuple):
    """A search problem: start and goal, vehicle, and obstacles."""

    start: VehicleState
    goal_m: tuple[float, float]
    """North, east."""
    reached_m: float
    places: Callable[[float], Floats]
    """(n, 2) where the obstacles are at a time, north, east, m."""
    radius_m: Floats
    """(n,) of the obstacles."""
    keep_m: float
    """Between their edges and the vehicle's middle, m."""
    can: VehicleSettings
    speeds_m_s: tuple[float, ...]
    """That it may go at; the first is the highest."""
    current_m_s: tuple[float, float]
    dt_s: float
    """Of a step of the vehicle;"""
    a_time: int
    """Number between two set points."""
    most_s: float
    """Patience."""


class TimedPath(NamedTuple):
    """A path with its set points."""

    orders: list[tuple[float, float]]
    """Heading and speed, each held for `steps` steps."""
    steps: int
    places: Floats
    """(k, 2) north, east after each step, up to the goal, m."""
    end: VehicleState
    """At the end of the last move."""

    @property
    def path_m(self) -> float:
        """Its length over ground."""
        return float(np.hypot(*np.diff(self.places, axis=0).T).sum())


def fastest_path(query: PathQuery) -> TimedPath | None:
    """Return it; None: there is none, or it takes more than `most_s` or too many states to find."""
    return _Search(query).found()


class _Search:
    def __init__(self, query: PathQuery) -> None:
        self._errand = query
        self._steps = query.a_time * max(1, round(MOVE_S / (query.a_time * query.dt_s)))
        self._move_s = self._steps * query.dt_s
        self._looked = np.unique(np.linspace(0, self._steps - 1, LOOKS).round().astype(np.intp))
        self._obstacles: list[Floats] = []
        """(looks, n, 2) where they are during each move."""
        self._states = [motion_of(query.start)]
        """All states so far, in blocks."""
        self._rows: list[tuple[int, int, int, int, float, float]] = [(0, 0, 0, -1, 0.0, 0.0)]
        """For each state: its block, its place in it, the number of moves to it, the previous state, heading and
        speed."""
        self._seen: set[int] = set()
        self._open: list[tuple[float, int]] = [(0.0, 0)]

    def found(self) -> TimedPath | None:
        while self._open and len(self._rows) < MOST_STATES:
            chosen = [heapq.heappop(self._open)[1] for _ in range(min(AT_ONCE, len(self._open)))]
            last = self._gone_on(chosen)
            if last is not None:
                return self._way_to(last)
        return None

    def _gone_on(self, chosen: list[int]) -> int | None:
        """Go on from some states; return the first that is at the goal."""
        query, (before, orders, moves) = self._errand, self._tried(chosen)
        after, places = moved(before, orders, query.can, query.current_m_s, query.dt_s, self._steps)
        clear = self._clear(places[self._looked], moves) & ((moves + 1) * self._move_s <= query.most_s)
        there = np.asarray(self._there(places).any(axis=0))
        left_s = self._left_s(after)
        keys = self._keys(after, moves + 1)
        block, best = len(self._states), None
        self._states.append(after)
        many = len(TURNS) * len(query.speeds_m_s)
        for which in np.flatnonzero(clear).tolist():
            key = int(keys[which])
            if key in self._seen:
                continue
            self._seen.add(key)
            number = len(self._rows)
            done = int(moves[which]) + 1
            self._rows.append((block, which, done, chosen[which // many],
                               float(orders.heading_rad[which]), float(orders.speed_m_s[which])))  # fmt: skip
            if there[which] and best is None:
                best = number
            heapq.heappush(self._open, (done * self._move_s + EAGER * float(left_s[which]), number))
        return best

    def _tried(self, chosen: list[int]) -> tuple[Motions, VehicleCommands, Ints]:
        """Return the vehicles, what each is to try, and how many moves each has made."""
        speeds = self._errand.speeds_m_s
        rows = [self._rows[each] for each in chosen]
        parts = [np.stack([values[place] for values in self._states[block]]) for block, place, *_ in rows]
        many = len(TURNS) * len(speeds)
        before = Motions(*np.repeat(np.array(parts), many, axis=0).T)
        most = math.radians(self._errand.can.turn_rate_deg_s)
        turns = np.tile(np.repeat(np.array(TURNS), len(speeds)), len(chosen)) * most * (self._move_s + YAW_S)
        orders = VehicleCommands(before.heading_rad + turns, np.tile(np.array(speeds), len(chosen) * len(TURNS)))
        return before, orders, np.repeat(np.array([row[2] for row in rows]), many)

    def _clear(self, places: Floats, moves: Ints) -> Mask:
        """Return (n,) which keep clear of everything; `places`: (looks, n, 2)."""
        query = self._errand
        if not query.radius_m.size:
            return np.ones(len(moves), bool)
        while len(self._obstacles) <= int(moves.max()):
            times = (len(self._obstacles) * self._steps + self._looked + 1) * query.dt_s + query.start.t_s
            self._obstacles.append(np.stack([query.places(each) for each in times.tolist()]))
        offset = np.stack([self._obstacles[each] for each in moves.tolist()], axis=1) - places[:, :, None]
        least = query.radius_m + (query.keep_m + CLOSER_M)
        return np.asarray((np.einsum("...i,...i", offset, offset) > least * least).all(axis=(0, 2)))

    def _there(self, places: Floats) -> Mask:
        offset = places - np.array(self._errand.goal_m)
        return np.asarray(np.hypot(offset[..., 0], offset[..., 1]) <= self._errand.reached_m)

    def _left_s(self, at: Motions) -> Floats:
        """Return (n,) the least time to the goal: with nothing in the way, once it heads for it."""
        query, fast = self._errand, min(self._errand.speeds_m_s[0], self._errand.can.most_m_s)
        lacks = fast - at.speed_m_s
        north, east = query.goal_m[0] - at.north_m, query.goal_m[1] - at.east_m
        away = np.hypot(north, east) - query.reached_m
        lost = lacks * lacks / (2.0 * query.can.acceleration_m_s2)
        reached = query.reached_m - np.where(away > fast * lacks / query.can.acceleration_m_s2, lost, 0.0)
        flow = math.hypot(*query.current_m_s)
        if fast <= flow:
            return np.maximum(away, 0.0) / (fast + flow)
        # |d - c t| = v t + r
        a = fast * fast - flow * flow
        b = fast * reached + north * query.current_m_s[0] + east * query.current_m_s[1]
        e = np.maximum(north * north + east * east - reached * reached, 0.0)
        return np.asarray((np.sqrt(b * b + a * e) - b) / a)

    def _keys(self, at: Motions, moves: Ints) -> Ints:
        cells = (at.north_m / CELL_M, at.east_m / CELL_M, at.speed_m_s / SPEED_M_S, moves * (self._move_s / TIME_S))
        heading = np.remainder(at.heading_rad * (HEADINGS / (2.0 * math.pi)), HEADINGS)
        key = np.floor(heading).astype(np.int64)
        for each in cells:
            key = key * 8192 + (np.floor(each).astype(np.int64) & 8191)
        return key

    def _way_to(self, last: int) -> TimedPath:
        orders: list[tuple[float, float]] = []
        while last > 0:
            *_, last, heading, speed = self._rows[last]
            orders.append((heading, speed))
        orders.reverse()
        at, legs = motion_of(self._errand.start), []
        for heading, speed in orders:
            order = VehicleCommands(np.array([heading]), np.array([speed]))
            at, places = moved(at, order, self._errand.can, self._errand.current_m_s, self._errand.dt_s, self._steps)
            legs.append(places)
        places = np.concatenate(legs)
        upto = int(np.argmax(self._there(places)[:, 0])) + 1
        start = self._errand.start
        end = start._replace(
            t_s=start.t_s + len(orders) * self._move_s, north_m=float(at.north_m[0]), east_m=float(at.east_m[0]),
            heading_rad=float(at.heading_rad[0]), speed_m_s=float(at.speed_m_s[0]), turn_rad_s=float(at.turn_rad_s[0]),
        )  # fmt: skip
        first = np.array([[start.north_m, start.east_m]])
        return TimedPath(orders, self._steps, np.concatenate([first, places[:upto, 0]]), end)
