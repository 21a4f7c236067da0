"""Poses of a .s7k recording: as written; what is cut short or no number is left out."""

import math
from pathlib import Path

from ods.sonar_link.files.s7k.pose import HEADING_RECORD, HEADING_SENSOR, GeodeticPose, encode_pose
from ods.sonar_link.files.s7k.recorded_poses import read_poses
from ods.sonar_link.s7k import drf

UTC_NS = 1_790_000_000_000_000_000
SECOND = 1_000_000_000
POSE = GeodeticPose(1.0, 0.17, -12.5, 0.125, -0.25, 4.5)


def test_poses_come_back_in_order_and_what_is_none_does_not(tmp_path: Path) -> None:
    file = tmp_path / "poses.s7k"
    later, sooner = encode_pose(POSE, UTC_NS + SECOND), encode_pose(POSE._replace(heading_rad=-0.5), UTC_NS)
    not_a_number = encode_pose(POSE._replace(roll_rad=math.nan), UTC_NS + 2 * SECOND)
    wild = encode_pose(POSE._replace(height_m=1e300), UTC_NS + 5 * SECOND)
    wild += encode_pose(POSE._replace(latitude_rad=1e300), UTC_NS + 6 * SECOND)
    half = encode_pose(POSE, UTC_NS + 3 * SECOND)[:200]
    short = encode_pose(POSE, UTC_NS + 4 * SECOND)
    short += drf.encode_record(HEADING_RECORD, b"\0\0", UTC_NS + 4 * SECOND, HEADING_SENSOR, recorded=True)
    file.write_bytes(b"noise" + later + half + sooner + not_a_number + wild + short)
    (first_ns, first), (second_ns, second) = read_poses(file)
    assert (first_ns, second_ns) == (UTC_NS, UTC_NS + SECOND)
    assert abs(first.heading_rad - math.tau + 0.5) < 1e-6
    assert second == POSE
