"""Clear water as a sensor_msgs/PointCloud2, one point for each sector of bearing.

Not as a LaserScan: its readers take the water before an echo for free, which may be unknown. A point's x, y, z is where
the nearest obstacle or echo is, or NaN where there is none: who reads no more gets obstacles only. The other fields say
from where to where the water is known to be empty.
"""

import math
from typing import Any

import numpy as np

from ods.messages import Clearance, PoseAt
from ods.ros2 import enu
from ods.ros2.messages import Messages

POINT_CLOUD = "sensor_msgs/msg/PointCloud2"
FIELDS = ("x", "y", "z", "azimuth", "clear_from", "clear_to", "nearest", "half_height")
"""float32 each: m; azimuth: rad, of the sector's middle, counter-clockwise from east."""
FLOAT32 = 7
SIZE = 4


def cloud(make: Messages, stamp_ns: int, clearance: Clearance, pose: PoseAt) -> Any:
    """Return the points, sectors from north clockwise, as in the message."""
    count = len(clearance.nearest_m)
    points = np.empty((count, len(FIELDS)), "<f4")
    azimuth = 0.5 * math.pi - (np.arange(count) + 0.5) * 2.0 * math.pi / max(count, 1)
    nearest = np.array([math.nan if each is None else each for each in clearance.nearest_m], np.float64)
    east, north, up = enu.enu(pose.position_ned)
    points[:, 0] = east + nearest * np.cos(azimuth)
    points[:, 1] = north + nearest * np.sin(azimuth)
    points[:, 2] = np.where(np.isnan(nearest), np.nan, up)
    points[:, 3] = np.remainder(azimuth + math.pi, 2.0 * math.pi) - math.pi
    points[:, 4], points[:, 5] = clearance.clear_from_m, clearance.clear_to_m
    points[:, 6], points[:, 7] = nearest, clearance.half_height_m
    fields = [make.new("sensor_msgs/msg/PointField", name, SIZE * at, FLOAT32, 1) for at, name in enumerate(FIELDS)]
    step = SIZE * len(FIELDS)
    data = np.frombuffer(points.tobytes(), np.uint8)
    header = make.header(stamp_ns, make.frames.map)
    return make.new(POINT_CLOUD, header, 1, count, fields, False, step, step * count, data, False)
