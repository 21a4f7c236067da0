"""By how much all echoes have turned about the vehicle within a second, where it is too fast for tracks to follow.

Nothing is tracked for it: the echoes of a ping are held against those of a second ago, turned by each angle that lets a
pair agree. Where the angle that most pairs agree with is far from 0 the heading has stepped, or the images are mirrored
and the vehicle turns.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.base.clock import NS
from ods.tracker.common_error.causes import SURELY
from ods.tracker.common_error.least_squares import FAST_MEMORY_S, Reduced
from ods.tracker.common_error.sightings import (
    EAST,
    LARGEST_M,
    LEAST_SIGMA_M,
    LEAST_SIGMA_RAD,
    NORTH,
    OWN,
    TURN,
    WHOLE,
)
from ods.tracker.measurement.scan import Scan, Vehicle

LONGEST_S = 3.0
"""Pings are compared that are `FAST_MEMORY_S` apart; where they come more seldom, from one to the next, up to this."""
LEAST_TURN, MOST_TURN = 0.05, 0.8
"""A smaller turn, rad, tracks follow; a larger one takes most echoes out of the fan."""
GATE_M = 0.5
"""Ranges of a pair may differ by so much, and bearings by `SURELY` standard deviations."""
MOST_AGREE, MORE_THAN_STILL = 0.6, 2.0
"""Share of the echoes that must agree with the turn, of those that it leaves in the fan; and the ratio of their number
to that of those that agree with none."""
FEWEST_PAIRS = 5
MOST_ECHOES = 32
"""Of a ping that are compared."""


class _Echoes(NamedTuple):
    """Of one ping: the m echoes of small objects."""

    t_s: float
    head: Floats
    """(2,) north, east, m, of the sonar's head;"""
    heading: float
    """rad."""
    place: Floats
    """(m, 2) north, east, m."""
    sigma: Floats
    """(m, 2) standard deviations along and across, m and rad."""
    fan: tuple[float, float, float, float]
    """Least and most range and bearing."""


class _Pairs(NamedTuple):
    """Echoes of two pings that belong together."""

    turn: float
    """rad."""
    before: Ints
    now: Ints
    """Their rows."""


class Turned(NamedTuple):
    """All echoes have turned."""

    reduced: Reduced
    """What the pairs say, by rates."""
    yaw_rate: float
    """The reported one of the vehicle, in the mean, rad/s."""


class EchoTurn:
    """Keeps the echoes of the last second."""

    def __init__(self) -> None:
        self._echoes: deque[_Echoes] = deque()

    def look(self, scan: Scan) -> Turned | None:
        """Take in the echoes of a ping; return how they have turned, None if they have not or too few show it."""
        if scan.vehicle is None or not scan.usable:
            return None
        now = _echoes(scan, scan.vehicle)
        self._echoes.append(now)
        while len(self._echoes) > 2 and now.t_s - self._echoes[1].t_s >= FAST_MEMORY_S:
            self._echoes.popleft()
        before = self._echoes[0]
        seconds = now.t_s - before.t_s
        if not FAST_MEMORY_S <= seconds <= LONGEST_S:
            return None
        pairs = _pairs(before, now)
        if pairs is None:
            return None
        return Turned(_equations(before, now, pairs, seconds), _angle(now.heading - before.heading) / seconds)


def _echoes(scan: Scan, vehicle: Vehicle) -> _Echoes:
    """Return what is compared of a ping."""
    echoes, sector, forward = scan.echoes.rows, scan.sector, vehicle.rotation[:2, 0]
    small = np.flatnonzero(echoes.radius < LARGEST_M)
    if len(small) > MOST_ECHOES:
        small = small[:: len(small) // MOST_ECHOES + 1]
    heading = math.atan2(forward[1], forward[0])
    azimuth, range_m = heading + echoes.bearing[small], echoes.range_m[small]
    place = vehicle.position[:2] + (range_m * np.array([np.cos(azimuth), np.sin(azimuth)])).T
    sigma = np.column_stack([echoes.sigma_range[small], echoes.sigma_bearing[small]])
    fan = sector.range_min_m, sector.range_max_m, sector.bearing_min_rad, sector.bearing_max_rad
    sigma = np.maximum(sigma, (LEAST_SIGMA_M, LEAST_SIGMA_RAD))
    return _Echoes(scan.t_ns / NS, vehicle.position[:2].copy(), heading, place, sigma, fan)


def _angle(rad: float) -> float:
    return math.remainder(rad, 2.0 * math.pi)


def _polar(place: Floats, head: Floats) -> tuple[Floats, Floats]:
    away = place - head
    return np.hypot(*away.T), np.arctan2(away[:, 1], away[:, 0])


def _wrapped(angles: Floats) -> Floats:
    return np.remainder(angles + np.pi, 2.0 * np.pi) - np.pi


def _pairs(before: _Echoes, now: _Echoes) -> _Pairs | None:
    """Return the pairs of echoes that the same turn puts in one place; None if it is small, or too few do."""
    (range_a, azimuth_a), (range_b, azimuth_b) = _polar(before.place, now.head), _polar(now.place, now.head)
    a, b = (np.abs(range_a[:, None] - range_b) < GATE_M).nonzero()
    turn = _wrapped(azimuth_b[b] - azimuth_a[a])
    gate = SURELY * np.hypot(before.sigma[a, 1], now.sigma[b, 1])
    still = _different(a[np.abs(turn) < gate])
    if _different(a) < max(FEWEST_PAIRS, MORE_THAN_STILL * still):
        return None
    possible = np.abs(turn) < MOST_TURN
    a, b, turn, gate = a[possible], b[possible], turn[possible], gate[possible]
    agree = np.abs(turn[:, None] - turn) < gate
    if not len(a):
        return None
    which = (np.arange(len(before.place)) == a[:, None]).astype(np.float32)
    best = int(np.argmax(np.count_nonzero(agree.astype(np.float32) @ which, axis=1)))
    if abs(middle := float(np.median(turn[agree[best]]))) < LEAST_TURN:
        return None
    inside = _inside(range_a, _wrapped(azimuth_a + middle - now.heading), now.fan)
    if _different(a[agree[best]]) < max(FEWEST_PAIRS, MORE_THAN_STILL * still, MOST_AGREE * inside):
        return None
    off = np.abs(turn - middle) / gate
    nearest = np.argsort(off)[: np.count_nonzero(off < 1.0)]
    for side in (a, b):
        nearest = nearest[np.sort(np.unique(side[nearest], return_index=True)[1])]
    return _Pairs(middle, a[nearest], b[nearest])


def _different(of: Ints) -> int:
    return len(set(of.tolist()))


def _inside(range_m: Floats, bearing: Floats, fan: tuple[float, float, float, float]) -> int:
    """Return how many places are in the fan."""
    near, far, port, starboard = fan
    return int(np.count_nonzero((range_m > near) & (range_m < far) & (bearing > port) & (bearing < starboard)))


def _equations(before: _Echoes, now: _Echoes, pairs: _Pairs, seconds: float) -> Reduced:
    """Return the information of pairs about the rates of turn and place, exact for any turn."""
    c, s = math.cos(pairs.turn), math.sin(pairs.turn)
    there = now.place[pairs.now] - now.head
    came = (before.place[pairs.before] - now.head) @ np.array([[c, s], [-s, c]])
    across = np.column_stack([-there[:, 1], there[:, 0]])
    rows = np.zeros((len(there), 2, WHOLE))
    rows[:, :, TURN] = seconds * across
    rows[:, 0, NORTH] = rows[:, 1, EAST] = seconds
    rows[:, :, -1] = there - came + pairs.turn * across
    away = np.hypot(*there.T)[:, None]
    along_m, across_rad = np.hypot(before.sigma[pairs.before], now.sigma[pairs.now]).T[:, :, None]
    white = np.stack([there / (away * along_m), across / (away**2 * across_rad)], axis=1) @ rows
    common = white[:, :, OWN:]
    return Reduced(common.swapaxes(1, 2) @ common, np.full(len(there), 2.0))
