#!/bin/sh
# kappe's "remove zero points" removes all points straight above and below the sensor.
#
# Version:   kappe 0.25.0 (pointcloud2 0.6.0, numpy 2.4.6)
# Behaviour: `remove_zero` of a point cloud keeps the points whose x or y is not 0; z is not looked at.
# Seen:      of (0, 0, 0), (0, 0, -12), (3, 0, 0) and (0, 4, 0): left are (3, 0, 0) and (0, 4, 0)
# Expected:  (0, 0, -12) is left, too: the setting is described as "Remove points with all zero coordinates (x, y, z)".
# Matters:   a beam that looks straight down in a frame whose z axis is vertical has x = y = 0, as an altimeter's and an
#            echo sounder's middle one. Its bottom goes without a word, and water without a bottom is left.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check kappe==0.25.0 pointcloud2==0.6.0 numpy==2.4.6
"$place/venv/bin/python" - <<'END'
import sys
from types import SimpleNamespace

import numpy as np
from kappe.module.pointcloud import SettingPointCloud, point_cloud
from pointcloud2 import create_cloud, read_points

FLOAT32, BYTES = 7, 4
FIELDS = [SimpleNamespace(name=name, offset=BYTES * i, datatype=FLOAT32, count=1) for i, name in enumerate("xyz")]


def kept(points, **settings):
    """Return the points of a PointCloud2 that a conversion by these settings leaves."""
    array = np.array(points, dtype=[(field.name, "<f4") for field in FIELDS])
    cloud = create_cloud(SimpleNamespace(), FIELDS, array)
    point_cloud(SettingPointCloud(**settings), SimpleNamespace(decoded_message=cloud))
    return [tuple(map(float, point)) for point in read_points(cloud)]


points = [(0.0, 0.0, 0.0), (0.0, 0.0, -12.0), (3.0, 0.0, 0.0), (0.0, 4.0, 0.0)]
seen = {False: kept(points), True: kept(points, remove_zero=True)}
if seen != {False: points, True: [(3.0, 0.0, 0.0), (0.0, 4.0, 0.0)]}:
    sys.exit(f"changed: points that are left, by remove_zero: {seen}")
print(f"as before: points that are left, by remove_zero: {seen}")
END
