"""Another sonar's pulses: they come in at a period of their own, whatever our pings do, and look like small bodies.

In time since a fixed instant they stand at even distances; from ping to ping their range then moves by a constant step
modulo the ping period. A body stands at one range, or moves along a line. So echoes that have no forerunner where a
body would have been are held against the pulses of one period, and where those explain several of them, and no body
does, all that arrive at the instants to come are pulses: they are left out, and their places are told as unseen.

What comes once a ping at nearly our own period (within 2 %, which is 15 m/s) is on a line, too, and stays an echo.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Detection, Ping, UnseenPart

PINGS = 12
"""Remembered."""
MOST_ARRIVALS = 24
"""In one direction that are held against a period."""
LONGEST_M = 2.0
"""In range: pulses of sonars are no longer."""
SLOW_MPS = 3.0
"""What moves no faster than this has a forerunner."""
NEAR_S = 0.4e-3
"""An echo that arrives so near to a pulse's instant is the pulse."""
BEARING_RAD = math.radians(4.0)
"""So near, beside the echoes' own widths, are those of one source."""
FORGOTTEN_S = 2.0
"""A train that was not heard for so long is forgotten."""
GAP_S = 3.0
"""After a pause of so long all is."""
FOLLOW_PLACE, FOLLOW_PERIOD = 0.3, 0.05
"""Shares of the error by which a train follows what is heard."""
MARGIN_M = 0.1


class _Arrival(NamedTuple):
    at_s: float
    """Since the first ping."""
    bearing_rad: float
    half_width_rad: float


class _Look(NamedTuple):
    """One ping."""

    begin_s: float
    """When its nearest sample was heard, since the first ping,"""
    end_s: float
    """and its farthest."""
    new: list[_Arrival]
    """Echoes that had no forerunner."""


@dataclass(slots=True)
class _Train:
    period_s: float
    at_s: float
    """Of a pulse."""
    bearing_rad: float
    heard_s: float


class Pulses(NamedTuple):
    """What of a ping's echoes are another sonar's pulses."""

    of_detections: list[bool]
    of_faint: list[bool]
    parts: list[UnseenPart]
    """Where they stand."""
    why: str
    """In plain words; empty: there are none."""


def no_pulses(detections: Sequence[Detection], faint: Sequence[Detection]) -> Pulses:
    """Return that none of the echoes is a pulse."""
    return Pulses([False] * len(detections), [False] * len(faint), [], "")


class PulseFinder:
    """Looks at the echoes of ping after ping."""

    def __init__(self) -> None:
        self._begun_ns, self._newest_ns = 0, 0
        self._looks: deque[_Look] = deque(maxlen=PINGS)
        self._trains: list[_Train] = []
        self._before = np.empty((0, 3))

    def sort_out(self, ping: Ping, detections: Sequence[Detection], faint: Sequence[Detection]) -> Pulses:
        """Return which of a ping's echoes are pulses."""
        since_s = (ping.t_ns - self._newest_ns) / NS
        if not 0.0 < since_s < GAP_S or ping.sound_speed <= 0.0:
            self._looks.clear()
            self._trains, self._before = [], np.empty((0, 3))
            self._begun_ns, since_s = ping.t_ns, 0.0
        self._newest_ns = ping.t_ns
        if ping.sound_speed <= 0.0:
            return no_pulses(detections, faint)
        look, candidates = self._look(ping, detections, since_s)
        self._looks.append(look)
        if self._trains:
            self._follow(look, [_arrival(echo, look, ping) for echo in detections])
        for arrival in candidates:
            if not any(_is_of(train, arrival) for train in self._trains):
                look.new.append(arrival)
                self._search(arrival)
        if not self._trains:
            return no_pulses(detections, faint)
        look.new[:] = [arrival for arrival in look.new if not any(_is_of(train, arrival) for train in self._trains)]
        return self._sorted(look, ping, detections, faint)

    def _look(self, ping: Ping, detections: Sequence[Detection], since_s: float) -> tuple[_Look, list[_Arrival]]:
        """Return the ping, and those of its echoes that may be pulses."""
        sent_s, per_m = (ping.t_ns - self._begun_ns) / NS, 2.0 / ping.sound_speed
        far_m = ping.range0_m + ping.samples * ping.dr_m
        look = _Look(sent_s + max(ping.range0_m, 0.0) * per_m, sent_s + far_m * per_m, [])
        table = np.array([(each.near_m, each.bearing_rad, each.bearing_extent_rad) for each in detections])
        before, self._before = self._before, table.reshape(-1, 3)
        alone = np.ones(len(detections), np.bool_)
        native.without_forerunner(self._before, before, SLOW_MPS * since_s, BEARING_RAD, alone)
        new = [
            _arrival(echo, look, ping)
            for echo, is_alone in zip(detections, alone.tolist(), strict=True)
            if is_alone and echo.range_extent_m <= LONGEST_M
        ]
        return look, new

    def _follow(self, look: _Look, arrivals: list[_Arrival]) -> None:
        for train in self._trains:
            mine = [arrival for arrival in arrivals if _is_of(train, arrival)]
            for arrival in mine:
                steps = round((arrival.at_s - train.at_s) / train.period_s)
                error_s = arrival.at_s - train.at_s - steps * train.period_s
                train.at_s += steps * train.period_s + FOLLOW_PLACE * error_s
                train.period_s += FOLLOW_PERIOD * error_s / max(steps, 1)
                train.bearing_rad, train.heard_s = arrival.bearing_rad, look.end_s
        self._trains = [train for train in self._trains if look.end_s - train.heard_s < FORGOTTEN_S]

    def _search(self, arrival: _Arrival) -> None:
        """Look for a train that the arrival, the newest of all, is part of."""
        rows = [
            (other.at_s, number)
            for number, look in enumerate(self._looks)
            for other in look.new
            if _is_near(arrival, other)
        ][-MOST_ARRIVALS:]
        if len(rows) < 5:
            return
        windows = np.array([(look.begin_s, look.end_s) for look in self._looks])
        found = np.empty(2)
        if native.find_train(np.array(rows), windows, found):
            period_s, at_s = found.tolist()
            self._trains.append(_Train(period_s, at_s, arrival.bearing_rad, self._looks[-1].end_s))

    def _sorted(self, look: _Look, ping: Ping, detections: Sequence[Detection], faint: Sequence[Detection]) -> Pulses:
        marks = [
            [any(_is_of(train, _arrival(echo, look, ping)) for train in self._trains) for echo in echoes]
            for echoes in (detections, faint)
        ]
        pulses = [
            echo for echoes, marked in zip((detections, faint), marks, strict=True)
            for echo, mark in zip(echoes, marked, strict=True) if mark
        ]  # fmt: skip
        if not pulses:
            return Pulses(marks[0], marks[1], [], "")
        periods = ", ".join(f"{1e3 * train.period_s:.1f} ms" for train in self._trains)
        parts = [_part(echo, max(ping.range0_m, 0.0)) for echo in pulses]
        return Pulses(marks[0], marks[1], parts, f"another sonar's pulses, each {periods}")


def _arrival(echo: Detection, look: _Look, ping: Ping) -> _Arrival:
    since_begin_s = 2.0 * (echo.near_m - max(ping.range0_m, 0.0)) / ping.sound_speed
    return _Arrival(look.begin_s + since_begin_s, echo.bearing_rad, 0.5 * echo.bearing_extent_rad)


def _is_near(one: _Arrival, other: _Arrival) -> bool:
    apart = abs(one.bearing_rad - other.bearing_rad)
    return apart <= BEARING_RAD + one.half_width_rad + other.half_width_rad


def _is_of(train: _Train, arrival: _Arrival) -> bool:
    if abs(arrival.bearing_rad - train.bearing_rad) > BEARING_RAD + arrival.half_width_rad:
        return False
    steps = (arrival.at_s - train.at_s) / train.period_s
    return abs(steps - round(steps)) * train.period_s <= NEAR_S


def _part(echo: Detection, least_m: float) -> UnseenPart:
    half_rad = 0.5 * echo.bearing_extent_rad
    near_m, far_m = echo.near_m - MARGIN_M, echo.near_m + echo.range_extent_m + MARGIN_M
    return UnseenPart(
        echo.bearing_rad - half_rad, echo.bearing_rad + half_rad, max(near_m, least_m), far_m, "interference"
    )
