"""The s7k records of a pose: position 1003, roll pitch heave 1012, heading 1013. Pure codec.

These three are what public readers (pyread7k, kluster) look for. Source: 7k Data Format Definition 3.12, sections 10.5,
10.14, 10.15, appendix B.
"""

import math
import struct
from typing import NamedTuple

from ods.sonar_link.s7k import drf

POSITION_RECORD = 1003
ROLL_PITCH_HEAVE_RECORD = 1012
HEADING_RECORD = 1013

POSITION_SENSOR, HEADING_SENSOR, ATTITUDE_SENSOR = drf.DeviceId(100), drf.DeviceId(101), drf.DeviceId(102)
"""Generic sensors."""
POSE_SENSORS = POSITION_SENSOR, HEADING_SENSOR, ATTITUDE_SENSOR
INERTIAL = 6
"""Positioning method: inertial, of unknown aiding."""

POSITION = struct.Struct("<IfdddBBBBB")
ROLL_PITCH_HEAVE = struct.Struct("<fff")
"""Their bodies."""


class GeodeticPose(NamedTuple):
    """Where the vehicle is and how it lies."""

    latitude_rad: float
    longitude_rad: float
    height_m: float
    """Above the WGS 84 ellipsoid."""
    roll_rad: float
    pitch_rad: float
    heading_rad: float
    """Clockwise from true north, any turn."""


def encode_pose(pose: GeodeticPose, utc_ns: int) -> bytes:
    """Return records 1003, 1012 and 1013, framed; heave is always 0. Raises ValueError for a time without a 7KTIME."""
    position = POSITION.pack(0, 0.0, pose.latitude_rad, pose.longitude_rad, pose.height_m, 0, 0, 0, INERTIAL, 0)
    attitude = ROLL_PITCH_HEAVE.pack(pose.roll_rad, pose.pitch_rad, 0.0)
    heading = struct.pack("<f", pose.heading_rad % math.tau)
    return b"".join(
        drf.encode_record(record_type, body, utc_ns, device, recorded=True)
        for record_type, device, body in (
            (POSITION_RECORD, POSITION_SENSOR, position),
            (ROLL_PITCH_HEAVE_RECORD, ATTITUDE_SENSOR, attitude),
            (HEADING_RECORD, HEADING_SENSOR, heading),
        )
    )
