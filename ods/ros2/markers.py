"""Obstacles as a visualization_msgs/MarkerArray: a cylinder each, and a line ahead of what moves."""

import math
from typing import Any

import numpy as np

from ods.base.frames.quaternion import Quaternion
from ods.messages import Obstacle, ObstacleList
from ods.ros2 import enu
from ods.ros2.messages import Messages

MARKERS = "visualization_msgs/msg/MarkerArray"
CYLINDER, LINE_LIST, ADD, DELETE_ALL = 3, 5, 0, 3
LIFETIME_S = 1
"""Time after which a marker that is not sent again disappears, s."""
LEAST_SPEED_M_S = 0.1
"""Slower ones have no line."""
AHEAD_S = 5.0
"""Lines reach where the obstacle will be then."""
LINE_M = 0.2
"""Their width."""
ORANGE, GREY = (1.0, 0.45, 0.1), (0.5, 0.5, 0.5)
"""Grey ones are those that an operator said to ignore."""
LEVEL: Quaternion = (1.0, 0.0, 0.0, 0.0)


def markers(make: Messages, stamp_ns: int, obstacle_list: ObstacleList) -> Any:
    """Return all markers of a list; the first one deletes those of the last list, the last one is all lines."""
    one = _Maker(make, stamp_ns)
    nowhere, line = make.place((0.0, 0.0, 0.0), LEVEL), make.vector((LINE_M, 0.0, 0.0))
    found = [one.marker("obstacles", 0, DELETE_ALL, CYLINDER, nowhere, line, 1.0)]
    found += [_cylinder(make, one, obstacle) for obstacle in obstacle_list.obstacles]
    if points := [point for obstacle in obstacle_list.obstacles for point in _line(make, obstacle)]:
        found.append(one.marker("velocities", 0, ADD, LINE_LIST, nowhere, line, 1.0, points))
    return make.new(MARKERS, found)


def _cylinder(make: Messages, one: "_Maker", obstacle: Obstacle) -> Any:
    across = 2.0 * obstacle.radius_m
    colour = ORANGE if obstacle.ignored_by < 0 else GREY
    place, scale = make.place(enu.enu(obstacle.position_ned), LEVEL), make.vector((across, across, across))
    return one.marker("obstacles", obstacle.id, ADD, CYLINDER, place, scale, obstacle.existence, colour=colour)


def _line(make: Messages, obstacle: Obstacle) -> list[Any]:
    if math.hypot(*obstacle.velocity_ned[:2]) < LEAST_SPEED_M_S:
        return []
    place, way = enu.enu(obstacle.position_ned), enu.enu(obstacle.velocity_ned)
    ahead = (place[0] + AHEAD_S * way[0], place[1] + AHEAD_S * way[1], place[2] + AHEAD_S * way[2])
    return [make.point(place), make.point(ahead)]


class _Maker:
    """Makes the markers of a list; what all of them have is made once."""

    def __init__(self, make: Messages, stamp_ns: int) -> None:
        self._new = make.new
        self._header = make.header(stamp_ns, make.frames.map)
        self._lifetime = make.new("builtin_interfaces/msg/Duration", LIFETIME_S, 0)
        nothing = np.zeros(0, np.uint8)
        self._picture = make.new("sensor_msgs/msg/CompressedImage", make.header(0, ""), "", nothing)
        self._mesh = make.new("visualization_msgs/msg/MeshFile", "", nothing)

    def marker(
        self,
        name: str,
        id_: int,
        action: int,
        kind: int,
        place: Any,
        scale: Any,
        seen: float,
        points: Any = (),
        *,
        colour: tuple[float, float, float] = ORANGE,
    ) -> Any:
        """Return one; `seen`: its existence."""
        return self._new(
            "visualization_msgs/msg/Marker",
            self._header, name, id_ % 2**31, kind, action, place, scale,
            self._new("std_msgs/msg/ColorRGBA", *colour, 0.3 + 0.6 * seen), self._lifetime,
            False, points, [], "", self._picture, [], "", "", self._mesh, False,
        )  # fmt: skip
