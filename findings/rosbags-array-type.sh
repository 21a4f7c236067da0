#!/bin/sh
# rosbags writes an array of another type of the same size bit by bit, as if it were of the message's type.
#
# Version:   rosbags 0.11.9 (numpy 2.4.6)
# Behaviour: serialize_cdr() copies the bytes of a numpy array. An array of other element size is refused; int32 or
#            big-endian float32 in a float32 field, or int8 in a uint8 field, are not.
# Seen:      LaserScan.ranges [1, 2, 3] as int32 come back as [1e-45, 3e-45, 4e-45], as big-endian float32 as
#            [4.6e-41, 9.0e-44, 2.3e-41]
# Expected:  [1.0, 2.0, 3.0], or an error as for float64: the definition says float32[], and the four bytes before a
#            CDR message say its byte order, here little-endian, for all of it.
# Matters:   ranges in whole millimetres, or read from a big-endian sonar record, become denormal numbers: zero
#            distance, below range_min, so a planner that follows the message's definition drops every obstacle.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check rosbags==0.11.9 numpy==2.4.6
"$place/venv/bin/python" - <<'END'
import sys

import numpy as np
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_JAZZY)
Time, Header, Scan = (
    store.types[name] for name in ("builtin_interfaces/msg/Time", "std_msgs/msg/Header", "sensor_msgs/msg/LaserScan")
)


def round_trip(kind):
    ranges = np.array([1, 2, 3], kind)
    scan = Scan(Header(Time(0, 0), "sonar"), -0.1, 0.1, 0.1, 0.0, 0.1, 0.5, 60.0, ranges, np.empty(0, np.float32))
    return store.deserialize_cdr(store.serialize_cdr(scan, Scan.__msgtype__), Scan.__msgtype__).ranges.tolist()


seen = {kind: round_trip(kind) for kind in ("<f4", "<i4", ">f4")}
try:
    round_trip("<f8")
except ValueError:
    refused = True
else:
    refused = False
wrong = all(0.0 < value < 1e-37 for kind in ("<i4", ">f4") for value in seen[kind])
if seen["<f4"] != [1.0, 2.0, 3.0] or not wrong or not refused:
    sys.exit(f"changed: ranges 1, 2, 3 come back as {seen}, float64 refused: {refused}")
print(f"as before: ranges 1, 2, 3 come back as {seen}, float64 refused: {refused}")
END
