"""The s7k records of a pose: position 1003, roll pitch heave 1012, heading 1013. Pure codec.

These three are what public readers (pyread7k, kluster) look for. Source: 7k Data Format Definition 3.12, sections 10.5,
10.14, 10.15, appendix B.
"""

import math
import struct

from ods.sonar_link.s7k import drf

POSITION = 1003
ROLL_PITCH_HEAVE = 1012
HEADING = 1013

POSITION_SENSOR, HEADING_SENSOR, ATTITUDE_SENSOR = 100, 101, 102
"""Device identifiers: generic sensors."""
INERTIAL = 6
"""Positioning method: inertial, of unknown aiding."""

_POSITION = struct.Struct("<IfdddBBBBB")


def encode_pose(
    utc_ns: int,
    latitude_rad: float,
    longitude_rad: float,
    height_m: float,
    roll_rad: float,
    pitch_rad: float,
    heading_rad: float,
) -> bytes:
    """Return records 1003, 1012 and 1013, framed; height is above the WGS 84 ellipsoid, heave always 0."""
    position = _POSITION.pack(0, 0.0, latitude_rad, longitude_rad, height_m, 0, 0, 0, INERTIAL, 0)
    attitude = struct.pack("<fff", roll_rad, pitch_rad, 0.0)
    heading = struct.pack("<f", heading_rad % math.tau)
    return b"".join(
        drf.encode_record(record_type, body, utc_ns, device, recorded=True)
        for record_type, device, body in (
            (POSITION, POSITION_SENSOR, position),
            (ROLL_PITCH_HEAVE, ATTITUDE_SENSOR, attitude),
            (HEADING, HEADING_SENSOR, heading),
        )
    )
