#!/bin/sh
# pyxtf drops the fraction of a second of navigation and gyro packets that say when their source measured them.
#
# Version:   pyxtf 1.5.0 (numpy 2.4.6)
# Behaviour: get_time() of XTFHeaderNavigation and XTFHeaderGyro takes `SourceEpoch` if it is not 0, and then ignores
#            `Microsecond`; without SourceEpoch the fraction is kept.
# Seen:      ten packets, 0.1 s apart, of one second: ten times 12:00:05
# Expected:  12:00:05.0, 12:00:05.1, ... SourceEpoch is whole seconds; the fraction stands in `Microsecond`, and the
#            method's own comment announces high-resolution fields on top of the epoch.
# Matters:   heading and position of a recorded dive come in steps of one second: at a turn of 10 degrees a second and
#            50 m range an obstacle moves by up to 8.7 m. The better a file's time stamps, the worse they are read.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check pyxtf==1.5.0 numpy==2.4.6
"$place/venv/bin/python" - "$place/dive.xtf" <<'END'
import calendar
import sys

import pyxtf

SECOND = (2026, 3, 1, 12, 0, 5)


def packet(kind, tenth, epoch):
    made = kind()
    made.Year, made.Month, made.Day, made.Hour, made.Minute, made.Second = SECOND
    made.Microsecond = 100_000 * tenth
    made.SourceEpoch = epoch
    made.NumBytesThisRecord = 64
    return made


def times(kind, number, epoch):
    with open(sys.argv[1], "wb") as file:
        file.write(pyxtf.XTFFileHeader().to_bytes())
        for tenth in range(10):
            file.write(packet(kind, tenth, epoch).to_bytes())
    _, packets = pyxtf.xtf_read(sys.argv[1])
    return len({packet.get_time() for packet in packets[number]})


epoch = calendar.timegm(SECOND)
seen = {
    "navigation": times(pyxtf.XTFHeaderNavigation, pyxtf.XTFHeaderType.navigation, epoch),
    "gyro": times(pyxtf.XTFHeaderGyro, pyxtf.XTFHeaderType.gyro, epoch),
    "navigation without SourceEpoch": times(pyxtf.XTFHeaderNavigation, pyxtf.XTFHeaderType.navigation, 0),
}
if seen != {"navigation": 1, "gyro": 1, "navigation without SourceEpoch": 10}:
    sys.exit(f"changed: different times among ten packets that are 0.1 s apart: {seen}")
print(f"as before: different times among ten packets that are 0.1 s apart: {seen}")
END
