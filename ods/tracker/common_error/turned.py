"""By how much all echoes have turned about the vehicle within a second, where it is too fast for tracks to follow.

Nothing is tracked for it: the echoes of a ping are held against those of a second ago, turned by each angle that lets a
pair agree. Where the angle that most pairs agree with is far from 0 the heading has stepped, or the images are mirrored
and the vehicle turns.
"""

from collections import deque
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.tracker.common_error.least_squares import WHOLE, Reduced
from ods.tracker.common_error.sightings import (
    EAST,
    LARGEST_M,
    LEAST_SIGMA_M,
    LEAST_SIGMA_RAD,
    NORTH,
    OWN,
    TURN,
)
from ods.tracker.measurement.scan import Scan

AGO_S = 1.0
"""Between the pings compared, s; where pings come more seldom, from one to the next, up to"""
LONGEST_S = 3.0
LEAST_TURN, MOST_TURN = 0.05, 0.8
"""A smaller turn, rad, tracks follow; a larger one takes most echoes out of the fan."""
GATE_M, GATE_SIGMAS = 0.5, 3.0
"""Ranges of a pair may differ by so much, and bearings by so many standard deviations."""
MOST_AGREE, MORE_THAN_STILL = 0.6, 2.0
"""Share of the echoes that must agree with the turn, of those that it leaves in the fan; and the ratio of their number
to that of those that agree with none."""
FEWEST_PAIRS = 5
STRONGEST = 64
"""Echoes of a ping that are compared."""


class _Heard(NamedTuple):
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


class Turned(NamedTuple):
    """All echoes have turned."""

    reduced: Reduced
    """What the pairs say, by rates."""
    yaw_rate: float
    """The reported one of the vehicle, in the mean, rad/s."""


class EchoTurn:
    """Keeps the echoes of the last second."""

    def __init__(self) -> None:
        self._heard: deque[_Heard] = deque()

    def look(self, scan: Scan) -> None:
        """Take in the echoes of a ping."""
        vehicle, echoes = scan.vehicle, scan.echoes.rows
        if vehicle is None or not scan.usable:
            return
        t_s, forward = scan.t_ns / 1e9, vehicle.rotation[:2, 0]
        small = np.flatnonzero(echoes.radius < LARGEST_M)[:STRONGEST]
        heading = float(np.arctan2(forward[1], forward[0]))
        azimuth, range_m = heading + echoes.bearing[small], echoes.range_m[small]
        place = vehicle.position[:2] + (range_m * np.array([np.cos(azimuth), np.sin(azimuth)])).T
        sigma = np.maximum(
            np.column_stack([echoes.sigma_range[small], echoes.sigma_bearing[small]]), (LEAST_SIGMA_M, LEAST_SIGMA_RAD)
        )
        sector = scan.sector
        fan = sector.range_min_m, sector.range_max_m, sector.bearing_min_rad, sector.bearing_max_rad
        self._heard.append(_Heard(t_s, vehicle.position[:2].copy(), heading, place, sigma, fan))
        while len(self._heard) > 2 and t_s - self._heard[1].t_s >= AGO_S:
            self._heard.popleft()

    def turned(self) -> Turned | None:
        """Return how the echoes have turned; None if they have not, or too few show it."""
        if len(self._heard) < 2:
            return None
        before, now = self._heard[0], self._heard[-1]
        seconds = now.t_s - before.t_s
        if not AGO_S <= seconds <= LONGEST_S:
            return None
        pairs = _pairs(before, now)
        if pairs is None:
            return None
        yaw_rate = float(np.arctan2(*_cross_dot(before.heading, now.heading))) / seconds
        return Turned(_equations(before, now, *pairs, seconds), yaw_rate)


def _cross_dot(a: float, b: float) -> tuple[float, float]:
    return float(np.sin(b - a)), float(np.cos(b - a))


def _polar(place: Floats, head: Floats) -> tuple[Floats, Floats]:
    away = place - head
    return np.hypot(*away.T), np.arctan2(away[:, 1], away[:, 0])


def _pairs(before: _Heard, now: _Heard) -> tuple[float, Ints, Ints] | None:
    """Return the turn that most pairs agree with, rad, and the pairs' echoes before and now; None: it is small."""
    (range_a, azimuth_a), (range_b, azimuth_b) = _polar(before.place, now.head), _polar(now.place, now.head)
    near = np.abs(range_a[:, None] - range_b) < GATE_M
    a, b = near.nonzero()
    turn = np.remainder(azimuth_b[b] - azimuth_a[a] + np.pi, 2.0 * np.pi) - np.pi
    gate = GATE_SIGMAS * np.hypot(before.sigma[a, 1], now.sigma[b, 1])
    possible = np.abs(turn) < MOST_TURN
    a, b, turn, gate = a[possible], b[possible], turn[possible], gate[possible]
    if len(a) < FEWEST_PAIRS:
        return None
    agree = np.abs(turn[:, None] - turn) < gate
    number = np.array([len(np.unique(a[row])) for row in agree])
    best = int(number.argmax())
    still = len(np.unique(a[np.abs(turn) < gate]))
    middle = float(np.median(turn[agree[best]]))
    range_min, range_max, bearing_min, bearing_max = now.fan
    bearing = np.remainder(azimuth_a + middle - now.heading + np.pi, 2.0 * np.pi) - np.pi
    inside = (range_a > range_min) & (range_a < range_max) & (bearing > bearing_min) & (bearing < bearing_max)
    wanted = max(FEWEST_PAIRS, MORE_THAN_STILL * still, MOST_AGREE * np.count_nonzero(inside))
    if abs(middle) < LEAST_TURN or number[best] < wanted:
        return None
    off = np.abs(turn - middle) / gate
    order = np.argsort(off)
    order = order[off[order] < 1.0]
    _, first = np.unique(a[order], return_index=True)
    kept = order[first]
    _, first = np.unique(b[kept], return_index=True)
    kept = kept[first]
    return middle, a[kept], b[kept]


def _equations(before: _Heard, now: _Heard, turn: float, a: Ints, b: Ints, seconds: float) -> Reduced:
    """Return the information of pairs about the rates of turn and place, exact for any turn."""
    c, s = np.cos(turn), np.sin(turn)
    there = now.place[b] - now.head
    came = (before.place[a] - now.head) @ np.array([[c, s], [-s, c]])
    across = np.column_stack([-there[:, 1], there[:, 0]])
    rows = np.zeros((len(a), 2, WHOLE))
    rows[:, :, TURN] = seconds * across
    rows[:, 0, NORTH] = rows[:, 1, EAST] = seconds
    rows[:, :, -1] = there - came + turn * across
    away = np.hypot(*there.T)
    sigma = np.hypot(before.sigma[a], now.sigma[b])
    whitening = np.stack([there / (away * sigma[:, 0])[:, None], across / (away**2 * sigma[:, 1])[:, None]], axis=1)
    white = (whitening @ rows)[:, :, OWN:]
    return Reduced(white.swapaxes(1, 2) @ white, np.full(len(a), 2.0))
