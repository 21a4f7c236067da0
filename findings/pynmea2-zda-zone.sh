#!/bin/sh
# pynmea2 adds the minutes of a negative time zone with the wrong sign.
#
# Version:   pynmea2 1.19.0
# Behaviour: ZDA's localdatetime is UTC plus zone hours plus zone minutes; the minutes' field has no sign of its own.
# Seen:      $GPZDA,120000.00,27,11,2026,-05,30: 07:30 local
# Expected:  06:30 by the reading of receiver makers (Trimble's help on ZDA: fields -5 and 15 are 5 h 15 min behind
#            GMT), or 17:30 by the other reading in use (the zone is added to local time to get GMT); 07:30 by none.
# Matters:   a ship's clock that is an hour off sorts a dive's files before or after the wrong survey line; times that
#            go into a pose must be taken from the UTC fields only.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check pynmea2==1.19.0
"$place/venv/bin/python" - <<'END'
import sys

import pynmea2

read = pynmea2.parse("$GPZDA,120000.00,27,11,2026,-05,30*4D")
seen = f"{read.localdatetime:%H:%M}"
if seen != "07:30":
    sys.exit(f"changed: local time at 12:00 UTC in zone -05,30: {seen}")
print(f"as before: local time at 12:00 UTC in zone -05,30: {seen}")
END
