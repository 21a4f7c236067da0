#!/bin/sh
# pynmea2 refuses THS, true heading and status of NMEA 0183, until somebody defines a class of its name.
#
# Version:   pynmea2 1.19.0
# Behaviour: `parse` raises SentenceTypeError for a whole sentence with the right checksum, where its type is none of
#            `pynmea2.types`; a class `THS(pynmea2.TalkerSentence)` anywhere in the program makes it known, by its name.
# Seen:      $HETHS,341.5,A*2E: SentenceTypeError: Unknown sentence type HETHS; with the class: ['341.5', 'A']
# Expected:  heading and mode: THS is an approved sentence of NMEA 0183 and IEC 61162-1; or a sentence without named
#            fields, as proprietary ones of unknown makers get.
# Matters:   a gyro of today may send THS only. Who counts SentenceTypeError as damage looks for a bad line; who
#            skips it has no heading, and says nothing.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check pynmea2==1.19.0
"$place/venv/bin/python" - <<'END'
import sys

import pynmea2

TEXT = "$HETHS,341.5,A*2E"
try:
    before = str(pynmea2.parse(TEXT, check=True).data)
except pynmea2.SentenceTypeError as error:
    before = error.args[0][0].rstrip(",")


class THS(pynmea2.TalkerSentence):
    fields = (("heading, deg", "heading"), ("mode", "mode"))


seen = (before, pynmea2.parse(TEXT, check=True).data)
if seen != ("Unknown sentence type HETHS", ["341.5", "A"]):
    sys.exit(f"changed: {TEXT}: {seen}")
print(f"as before: {TEXT}: {seen}")
END
