"""Obstacles as a visualization_msgs/MarkerArray: a cylinder each, and an arrow for what moves."""

import math
from typing import Any

import numpy as np

from ods.base.quaternion import Quaternion, Vector3
from ods.messages import Obstacle, ObstacleList
from ods.ros2 import enu
from ods.ros2.messages import Messages

MARKERS = "visualization_msgs/msg/MarkerArray"
ARROW, CYLINDER, ADD, DELETE_ALL = 0, 3, 0, 3
LIFETIME_S = 1
"""A marker that is not sent anew disappears after so long."""
LEAST_SPEED_M_S = 0.1
"""Slower ones have no arrow."""
ARROW_S = 5.0
"""Arrows reach where the obstacle will be then."""
SHAFT_M, HEAD_M = 0.2, 0.5
ORANGE = (1.0, 0.45, 0.1)
LEVEL: Quaternion = (1.0, 0.0, 0.0, 0.0)


def markers(make: Messages, stamp_ns: int, picture: ObstacleList) -> Any:
    """Return all markers of a list; the first one deletes those of the last list."""
    header = make.header(stamp_ns, make.frames.map)
    found = [_marker(make, header, 0, DELETE_ALL)]
    for obstacle in picture.obstacles:
        across = 2.0 * obstacle.radius_m
        found.append(_marker(make, header, CYLINDER, ADD, obstacle, (across, across, across)))
        if math.hypot(*obstacle.velocity_ned[:2]) >= LEAST_SPEED_M_S:
            found.append(_marker(make, header, ARROW, ADD, obstacle, (SHAFT_M, HEAD_M, 0.0)))
    return make.new(MARKERS, found)


def _marker(
    make: Messages,
    header: Any,
    kind: int,
    action: int,
    obstacle: Obstacle | None = None,
    scale: Vector3 = (0.0, 0.0, 0.0),
) -> Any:
    place: Vector3 = (0.0, 0.0, 0.0)
    id_, seen, points = 0, 1.0, []
    if obstacle is not None:
        id_, seen = obstacle.id % 2**31, obstacle.existence
        place = enu.enu(obstacle.position_ned)
        if kind == ARROW:
            way = enu.enu(obstacle.velocity_ned)
            ahead = (place[0] + ARROW_S * way[0], place[1] + ARROW_S * way[1], place[2] + ARROW_S * way[2])
            points, place = [make.point(place), make.point(ahead)], (0.0, 0.0, 0.0)
    new = make.new
    picture = new("sensor_msgs/msg/CompressedImage", make.header(0, ""), "", np.zeros(0, np.uint8))
    return new(
        "visualization_msgs/msg/Marker",
        header, "velocities" if kind == ARROW and obstacle else "obstacles", id_, kind, action,
        make.place(place, LEVEL), make.vector(scale),
        new("std_msgs/msg/ColorRGBA", *ORANGE, 0.3 + 0.6 * seen),
        new("builtin_interfaces/msg/Duration", LIFETIME_S, 0),
        False, points, [], "", picture, [], "", "",
        new("visualization_msgs/msg/MeshFile", "", np.zeros(0, np.uint8)), False,
    )  # fmt: skip
