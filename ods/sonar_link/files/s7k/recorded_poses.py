"""The vehicle's poses in a .s7k recording, as `ods record` writes them: 1003, 1012 and 1013 of one time."""

import math
import struct
from collections import Counter
from pathlib import Path

from ods.base.files.in_file import opened
from ods.sonar_link.files.ping_sequence import FARTHEST_M
from ods.sonar_link.files.s7k.pose import (
    HEADING_RECORD,
    POSITION,
    POSITION_RECORD,
    ROLL_PITCH_HEAVE,
    ROLL_PITCH_HEAVE_RECORD,
    GeodeticPose,
)
from ods.sonar_link.s7k.drf import S7kRecord
from ods.sonar_link.s7k.framer import RecordFramer

CHUNK_BYTES = 1024 * 1024
LONGEST_RECORD_BYTES = 64 * 1024 * 1024
_PARTS = {POSITION_RECORD, ROLL_PITCH_HEAVE_RECORD, HEADING_RECORD}


def read_poses(path: Path) -> list[tuple[int, GeodeticPose]]:
    """Return the poses of a recording with their UTC, ns, in order of time. Raises OSError.

    What has no time, is cut short, no number or beyond the earth, or lacks one of the three records of its time is left
    out.
    """
    framer = RecordFramer(LONGEST_RECORD_BYTES, Counter())
    parts: dict[int, dict[int, bytes]] = {}
    with opened(path) as file:
        while chunk := file.read(CHUNK_BYTES):
            for record in framer.feed(chunk):
                _keep(record, parts)
    whole = {t_ns: found for t_ns, found in parts.items() if found.keys() == _PARTS}
    poses = ((t_ns, _pose(whole[t_ns])) for t_ns in sorted(whole))
    return [(t_ns, pose) for t_ns, pose in poses if pose is not None]


def _keep(record: S7kRecord, parts: dict[int, dict[int, bytes]]) -> None:
    if record.record_type in _PARTS and record.time_ns is not None:
        parts.setdefault(record.time_ns, {})[record.record_type] = record.body


def _pose(found: dict[int, bytes]) -> GeodeticPose | None:
    try:
        _, _, latitude, longitude, height, *_ = POSITION.unpack_from(found[POSITION_RECORD])
        roll, pitch, _ = ROLL_PITCH_HEAVE.unpack_from(found[ROLL_PITCH_HEAVE_RECORD])
        (heading,) = struct.unpack_from("<f", found[HEADING_RECORD])
    except struct.error:
        return None
    pose = GeodeticPose(latitude, longitude, height, roll, pitch, heading)
    on_earth = abs(latitude) <= math.pi / 2 and abs(longitude) <= 2 * math.pi and abs(height) <= FARTHEST_M
    return pose if on_earth and all(map(math.isfinite, pose)) else None
