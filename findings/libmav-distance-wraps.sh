#!/bin/sh
# libmav sends an obstacle distance of 700 m as 44.64 m.
#
# Version:   libmav 0.1.1; compared: pymavlink 2.4.50
# Behaviour: a number that an integer field cannot hold is reduced modulo 2 to the number of its bits; a list shorter
#            than the array leaves the rest of the array as it was. Neither is an error.
# Seen:      OBSTACLE_DISTANCE.distances (uint16, cm) of 72 times 70000: 72 times 4464; then 71 times 300: the 72nd is
#            still 4464
# Expected:  an error, as for a list that is too long ("Data of length 90 does not fit"); pymavlink refuses 70000
#            (struct.error) and 71 (IndexError).
# Matters:   700 m of free water becomes an obstacle at 44.64 m, and 655.36 m one at 0. A sector that a list leaves out
#            repeats the distance of an earlier one.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check libmav==0.1.1 pymavlink==2.4.50
"$place/venv/bin/python" - "$place/messages.xml" <<'END'
import struct
import sys
from pathlib import Path

import libmav
from pymavlink.dialects.v20 import common

DEFINITION = """<mavlink><messages><message id="330" name="OBSTACLE_DISTANCE">
<field type="uint64_t" name="time_usec">us</field>
<field type="uint8_t" name="sensor_type">MAV_DISTANCE_SENSOR</field>
<field type="uint16_t[72]" name="distances">cm</field>
<field type="uint8_t" name="increment">deg</field>
<field type="uint16_t" name="min_distance">cm</field>
<field type="uint16_t" name="max_distance">cm</field>
<extensions/>
<field type="float" name="increment_f">deg</field>
<field type="float" name="angle_offset">deg</field>
<field type="uint8_t" name="frame">MAV_FRAME</field>
</message></messages></mavlink>"""


def refused(write, *errors):
    try:
        write()
    except errors:
        return True
    return False


def by_pymavlink(distances):
    sent = common.MAVLink_obstacle_distance_message(0, 0, distances, 5, 50, 65000)
    return sent.pack(common.MAVLink(None))


file = Path(sys.argv[1])
file.write_text(DEFINITION)
messages = libmav.MessageSet(str(file))  # must live as long as the message
message = messages.create("OBSTACLE_DISTANCE")
message["distances"] = 72 * [70000]
far = list(message["distances"])
message["distances"] = 71 * [300]
short = list(message["distances"])
checked = (
    refused(lambda: message.set_from_dict({"distances": 90 * [300]}), IndexError),
    refused(lambda: by_pymavlink(72 * [70000]), struct.error),
    refused(lambda: by_pymavlink(71 * [300]), IndexError),
)
seen = f"70000 cm: {sorted(set(far))}; then 71 of 300 cm: {short[:1]} ... {short[71:]}; others refuse: {checked}"
if far != 72 * [4464] or short != [*(71 * [300]), 4464] or not all(checked):
    sys.exit(f"changed: {seen}")
print(f"as before: {seen}")
END
