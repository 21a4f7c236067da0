#!/bin/sh
# pynmea2 names the speed over ground of a Nortek DVL the speed of sound.
#
# Version:   pynmea2 1.19.0
# Behaviour: the third field of $PNORBT4 (bottom track) is the attribute sound_speed; there is none for a speed.
# Seen:      $PNORBT4,0,0,0.812,231.5,0.00210,17.4: sound_speed 0.812
# Expected:  a speed over ground of 0.812 m/s towards 231.5 deg: Nortek's manual of the Signature VM, 7.1.8, names the
#            fields DT1, DT2, speed over ground (m/s), direction, figure of merit, distance to the bottom.
# Matters:   who takes a sound speed from any sentence that has one scales all sonar ranges by 0.812 / 1500; and who
#            looks for the vehicle's speed finds none. The field has to be taken by its position.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check pynmea2==1.19.0
"$place/venv/bin/python" - <<'END'
import functools
import operator
import sys

import pynmea2

body = "PNORBT4,0,0,0.812,231.5,0.00210,17.4"
checksum = functools.reduce(operator.xor, body.encode())
read = pynmea2.parse(f"${body}*{checksum:02X}", check=True)
names = [field[1] for field in read.fields]
seen = f"fields {' '.join(names)}; sound_speed {getattr(read, 'sound_speed', None)}"
if names[2] != "sound_speed" or read.sound_speed != 0.812:
    sys.exit(f"changed: {seen}")
print(f"as before: {seen}")
END
