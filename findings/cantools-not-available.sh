#!/bin/sh
# cantools decodes "not available" of J1939 and NMEA 2000 as a number beyond the signal's own range.
#
# Version:   cantools 45.1.0; compared: nmea2000 2026.10.3
# Behaviour: decode_message() scales whatever bits came; the [minimum|maximum] of the DBC is looked at in encoding only.
# Seen:      heading 0xFFFF in PGN 127250 with [0|6.2831]: 6.5535 rad by cantools, None by the package nmea2000
# Expected:  no value, an error, or a mark: in J1939-71 and NMEA 2000 all bits set say that a value is not available
#            (and the next lower raw value, or range of values, an error), and 6.5535 rad is outside the DBC's limits.
# Matters:   an INS that has lost its heading sends this 10 times a second. 6.5535 rad is a plausible angle, 15.5
#            degrees beyond north: all obstacles turn with it.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check cantools==45.1.0 nmea2000==2026.10.3
"$place/venv/bin/python" - <<'END'
import sys

import cantools
from nmea2000.decoder import NMEA2000Decoder

IDENTIFIER = 0x09F11201  # priority 2, PGN 127250, source 1
DBC = f"""VERSION ""
NS_ :
BS_ :
BU_: INS
BO_ {IDENTIFIER | 1 << 31} VesselHeading: 8 INS
 SG_ Heading : 8|16@1+ (0.0001,0) [0|6.2831] "rad" INS
"""
NOT_AVAILABLE = bytes.fromhex("01 FFFF FF7F FF7F FC")

frame = cantools.database.load_string(DBC).decode_message(IDENTIFIER, NOT_AVAILABLE)
line = "2026-03-01T12:00:00.000Z,2,127250,1,255,8," + NOT_AVAILABLE.hex(",")
message = NMEA2000Decoder().decode(line)
seen = (round(frame["Heading"], 4), message.get_field_by_id("heading").value)
if seen != (6.5535, None):
    sys.exit(f"changed: heading 0xFFFF by cantools and by nmea2000: {seen}")
print(f"as before: heading 0xFFFF by cantools and by nmea2000: {seen}")
END
