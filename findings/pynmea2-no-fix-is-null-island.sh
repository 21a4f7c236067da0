#!/bin/sh
# pynmea2 gives latitude 0, longitude 0 for a sentence that has no position.
#
# Version:   pynmea2 1.19.0
# Behaviour: `latitude` and `longitude` are 0.0 where the fields are empty; other empty fields of the same sentence, as
#            the altitude, are None.
# Seen:      $GPGGA,120000.00,,,,,0,00,,,M,,M,,: latitude 0.0, longitude 0.0, altitude None
# Expected:  None: by NMEA 0183 an empty (null) field says that a value is not available, not that it is zero.
# Matters:   a receiver under water sends such a sentence once a second. Without a look at the quality field the vehicle
#            is in the Gulf of Guinea, which is a valid position: a jump that no range check finds.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check pynmea2==1.19.0
"$place/venv/bin/python" - <<'END'
import sys

import pynmea2

read = pynmea2.parse("$GPGGA,120000.00,,,,,0,00,,,M,,M,,*4B", check=True)
seen = (read.latitude, read.longitude, read.altitude)
if seen != (0.0, 0.0, None):
    sys.exit(f"changed: latitude, longitude, altitude of a GGA without a fix: {seen}")
print(f"as before: latitude, longitude, altitude of a GGA without a fix: {seen}")
END
