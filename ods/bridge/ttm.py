"""Obstacles as NMEA 0183 TTM sentences, tracked target messages: true bearing, nautical miles, knots.

A target has a number from 0 to 99: an obstacle keeps its own while it is listed, and one that leaves the list is sent
once more, as lost.
"""

import math
from collections import deque
from datetime import UTC, datetime

import pynmea2

from ods.base.clock import NS
from ods.bridge.encoder import Encoded
from ods.bridge.extrapolated_list import ExtrapolatedList
from ods.bridge.settings import TtmSettings
from ods.messages import Obstacle

NUMBERS = 100
NAUTICAL_MILE_M = 1852.0
KNOT = NAUTICAL_MILE_M / 3600.0
"""m/s."""


class TtmEncoder:
    """Lists to sentences."""

    def __init__(self, settings: TtmSettings) -> None:
        self._settings = settings
        self._numbers: dict[int, int] = {}
        """By the obstacle's id."""
        self._free = deque(range(NUMBERS))
        """The one that was given back longest ago comes first."""

    def encode(self, extrapolated: ExtrapolatedList) -> Encoded:
        """Return a sentence for each obstacle, the nearest first, and before them those of what is lost."""
        nearest = extrapolated.nearest(self._settings.most_obstacles)
        listed = {obstacle.id for obstacle in nearest}
        lost = [number for id_, number in self._numbers.items() if id_ not in listed]
        self._numbers = {id_: number for id_, number in self._numbers.items() if id_ in listed}
        self._free.extend(lost)
        for obstacle in nearest:
            if obstacle.id not in self._numbers:
                self._numbers[obstacle.id] = self._free.popleft()
        utc = _utc(extrapolated)
        fields = [[f"{number:02d}", *[""] * 10, "L", "", utc, "A"] for number in lost]
        fields += [[f"{self._numbers[each.id]:02d}", *_target(each, extrapolated), "", utc, "A"] for each in nearest]
        talker = self._settings.talker
        lines = [f"{pynmea2.TTM(talker, 'TTM', texts)}\r\n".encode() for texts in fields]
        return Encoded(lines, extrapolated.left_out(len(nearest)))


def _target(obstacle: Obstacle, extrapolated: ExtrapolatedList) -> list[str]:
    """Return the fields from the distance to the status: the edge's distance, the centre's bearing.

    The name of one that an operator said to ignore begins with IGN.
    """
    north, east, _ = extrapolated.place(obstacle)
    own_north, own_east, _ = extrapolated.vehicle()
    velocity_north, velocity_east, _ = obstacle.velocity_ned
    cpa = obstacle.cpa
    return [
        _miles(extrapolated.edge_m(obstacle)),
        _degrees(north - own_north, east - own_east),
        "T",
        f"{math.hypot(velocity_north, velocity_east) / KNOT:.2f}",
        _degrees(velocity_north, velocity_east),
        "T",
        "" if cpa is None else _miles(cpa.distance_m),
        "" if cpa is None else f"{extrapolated.approach_s(cpa) / 60.0:.2f}",
        "N",
        f"{'IGN' if obstacle.ignored_by >= 0 else 'ODS'}{obstacle.id}",
        "T",
    ]


def _miles(metres: float) -> str:
    """Return a distance, nautical miles; where the vehicle is inside an obstacle, 0."""
    return f"{max(metres, 0.0) / NAUTICAL_MILE_M:.4f}"


def _degrees(north: float, east: float) -> str:
    """Return a direction, deg clockwise from true north, [0, 360)."""
    return f"{round(math.degrees(math.atan2(east, north)) % 360.0, 1) % 360.0:05.1f}"


def _utc(extrapolated: ExtrapolatedList) -> str:
    """Return the time of day, hhmmss.ss; empty where UTC is not to be relied on."""
    if extrapolated.obstacle_list.utc_source == "unsure":
        return ""
    time = datetime.fromtimestamp(extrapolated.utc_ns / NS, UTC)
    return f"{time:%H%M%S}.{time.microsecond // 10_000:02d}"
