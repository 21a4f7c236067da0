#!/bin/sh
# mcap-ros2-support fills a short fixed array with zeros, cuts a long one, and ignores a misspelt field.
#
# Version:   mcap-ros2-support 0.6.0 (mcap 1.6.0); compared: rosbags 0.11.9 (numpy 2.4.6)
# Behaviour: the writer takes as many elements as a fixed-size array has and writes 0 for those that lack; bounded
#            sequences are cut at their bound; fields that the message does not have are passed over; none is an error.
#            It extends the caller's own list, by None.
# Seen:      a 3 x 3 covariance (9 values) in a field of 36: read back as 9 values and 27 zeros; five values in four:
#            four; {"covarance": ...}: all zeros; the list that was handed over has 36 elements afterwards
# Expected:  an error: a fixed array has exactly its number of elements (ROS 2 interface definition). rosbags refuses
#            the 9 values ("Unexpected array length").
# Matters:   a covariance with zeros on its diagonal says that a pose is known exactly: the consumer then trusts it more
#            than any other, and gates obstacles that are 1 m off.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check \
    mcap==1.6.0 mcap-ros2-support==0.6.0 rosbags==0.11.9 numpy==2.4.6
"$place/venv/bin/python" - <<'END'
import io
import sys

import numpy as np
from mcap_ros2.reader import read_ros2_messages
from mcap_ros2.writer import Writer
from rosbags.typesys import Stores, get_typestore

VARIANCES = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]


def round_trip(definition, message):
    file = io.BytesIO()
    writer = Writer(file)
    writer.write_message("/pose", writer.register_msgdef("test_msgs/msg/Pose", definition), message)
    writer.finish()
    file.seek(0)
    (read,) = read_ros2_messages(file)
    return list(read.ros_msg.covariance)


def rosbags_refuses():
    store = get_typestore(Stores.ROS2_JAZZY)
    geometry = {name: store.types[f"geometry_msgs/msg/{name}"] for name in ("Point", "Quaternion", "Pose")}
    pose = geometry["Pose"](geometry["Point"](0.0, 0.0, 0.0), geometry["Quaternion"](0.0, 0.0, 0.0, 1.0))
    kind = store.types["geometry_msgs/msg/PoseWithCovariance"]
    try:
        store.serialize_cdr(kind(pose, np.array(VARIANCES)), kind.__msgtype__)
    except Exception as error:
        return "array length" in str(error)
    return False


handed_over = list(VARIANCES)
short = round_trip("float64[36] covariance", {"covariance": handed_over})
long = round_trip("float64[4] covariance", {"covariance": VARIANCES[:5]})
misspelt = round_trip("float64[4] covariance", {"covarance": VARIANCES[:4]})
silent = short == VARIANCES + 27 * [0.0] and long == VARIANCES[:4] and misspelt == 4 * [0.0]
extended = handed_over == VARIANCES + 27 * [None]
refused = rosbags_refuses()
seen = f"9 values for 36: {short[:10]}..., list extended: {extended}, rosbags refuses: {refused}; "
seen += f"5 for 4: {long}; misspelt: {misspelt}"
if not (silent and extended and refused):
    sys.exit(f"changed: {seen}")
print(f"as before: {seen}")
END
