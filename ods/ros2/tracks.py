"""Obstacles as radar_msgs/RadarTracks, in the frame of the map: velocities over ground."""

from typing import Any

import numpy as np

from ods.messages import Obstacle, ObstacleList
from ods.ros2 import definitions as texts, enu
from ods.ros2.messages import Messages

NO_CLASSIFICATION = 0
UPPER = [0, 1, 2, 4, 5, 8]
"""xx, xy, xz, yy, yz, zz of a 3 x 3 matrix, row by row."""


def tracks(make: Messages, stamp_ns: int, obstacle_list: ObstacleList) -> Any:
    """Return a track for each obstacle."""
    found = [_track(make, obstacle) for obstacle in obstacle_list.obstacles]
    return make.new(texts.RADAR_TRACKS, make.header(stamp_ns, make.frames.map), found)


def _track(make: Messages, o: Obstacle) -> Any:
    across, of_diameter = 2.0 * o.radius_m, 2.0 * o.sigma_radius
    return make.new(
        texts.RADAR_TRACK,
        make.uuid(o.id),
        make.point(enu.enu(o.position_ned)),
        make.vector(enu.enu(o.velocity_ned)),
        make.vector((0.0, 0.0, 0.0)),
        make.vector((across, across, across)),
        NO_CLASSIFICATION,
        _upper(enu.covariance(o.sigma_position, o.covariance_ne)),
        _upper(enu.covariance(o.sigma_velocity)),
        np.zeros(6, np.float32),
        _upper(enu.covariance((of_diameter, of_diameter, of_diameter))),
    )


def _upper(covariance: tuple[float, ...]) -> Any:
    return np.array(covariance, np.float32)[UPPER]
