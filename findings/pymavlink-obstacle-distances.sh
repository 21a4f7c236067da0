#!/bin/sh
# pymavlink sends the first 72 of any number of obstacle distances, without a word.
#
# Version:   pymavlink 2.4.50
# Behaviour: a message's array field takes as many elements as it has and leaves out the rest; too few raise IndexError.
# Seen:      OBSTACLE_DISTANCE of 90 distances of 1 degree, the only obstacle in the 80th: read back 72 distances, all
#            of them 4001 (free); 71 distances: IndexError
# Expected:  an error both ways: by the message's definition `distances` has 72 elements, and a wider fan has to be
#            put into 72 sectors by the sender.
# Matters:   a fan of 90 beams loses its last 18 degrees to starboard, and the autopilot sees free water there.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check pymavlink==2.4.50
"$place/venv/bin/python" - <<'END'
import sys

from pymavlink.dialects.v20 import common

FREE, MAXIMUM = 4001, 4000  # cm; maximum + 1 says that nothing is there


def read_back(distances):
    # time, sensor type, distances, increment, minimum, maximum, increment and first angle in degrees, frame
    sent = common.MAVLink_obstacle_distance_message(
        0, 0, distances, 1, 50, MAXIMUM, 1.0, -45.0, common.MAV_FRAME_BODY_FRD
    )
    (read,) = common.MAVLink(None).parse_buffer(sent.pack(common.MAVLink(None, srcSystem=1, srcComponent=1)))
    return read.distances


read = read_back([*(79 * [FREE]), 300, *(10 * [FREE])])
try:
    read_back(71 * [FREE])
except IndexError:
    refused = True
else:
    refused = False
if len(read) != 72 or set(read) != {FREE} or not refused:
    sys.exit(f"changed: 90 distances are read back as {len(read)}: {sorted(set(read))}; 71 refused: {refused}")
print(f"as before: 90 distances are read back as {len(read)}: {sorted(set(read))}; 71 refused: {refused}")
END
