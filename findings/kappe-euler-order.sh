#!/bin/sh
# kappe turns by roll, pitch and yaw in the order opposite to that of ROS.
#
# Version:   kappe 0.25.0; compared: scipy 1.17.1
# Behaviour: `euler_deg` of a rotation (of a static transform, a transform's offset, a point cloud) turns about the axes
#            x, y, z that turn along, in this order. The manual gives no order; a comment in the source does.
# Seen:      [90, 0, 90]: what looks along x looks along z, straight up, afterwards
# Expected:  along y: roll, pitch and yaw of ROS are about fixed x, y, z axes in this order (REP 103), as in URDF, tf2's
#            setRPY and static_transform_publisher.
# Matters:   a sonar's mounting taken over from URDF is right with one angle and wrong with two: a head that is rolled
#            and turned to port looks up, and all its echoes lie in another place.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check kappe==0.25.0 numpy==2.4.6 scipy==1.17.1
"$place/venv/bin/python" - <<'END'
import sys

from kappe.utils.settings import SettingRotation
from scipy.spatial.transform import Rotation

AHEAD = (1.0, 0.0, 0.0)


def looks(turn):
    return [round(float(part), 6) + 0.0 for part in turn.apply(AHEAD)]


def by_kappe(*angles):
    return looks(Rotation.from_quat(SettingRotation(euler_deg=angles).quaternion))


seen = {
    "yaw only": by_kappe(0, 0, 90),
    "roll and yaw": by_kappe(90, 0, 90),
    "roll and yaw about fixed axes": looks(Rotation.from_euler("xyz", (90, 0, 90), degrees=True)),
}
expected = {"yaw only": [0, 1, 0], "roll and yaw": [0, 0, 1], "roll and yaw about fixed axes": [0, 1, 0]}
if seen != expected:
    sys.exit(f"changed: where x ends: {seen}")
print(f"as before: where x ends: {seen}")
END
