#!/bin/sh
# python-can reads most error frames of a candump log as ordinary data frames.
#
# Version:   python-can 4.6.1
# Behaviour: CanutilsLogReader takes a line as an error frame only if the identifier has both the flag of an error frame
#            (0x20000000) and the class "bus error" (0x80). Other classes come as data frames with a 29-bit identifier.
# Seen:      20000040#... (bus off) gives a data frame, id 0x40, extended, 8 bytes; 20000004#... (controller
#            problem) gives a data frame, id 0x4; 20000088#... gives an error frame, but with id 0: the class is gone
# Expected:  three error frames that say what happened. linux/can.h: 0x20000000 alone marks an error frame;
#            linux/can/error.h: the other bits are classes, of which 0x80 is one. They are written so by
#            candump -l can0,0:0,#FFFFFFFF.
# Matters:   that a bus went off is why poses stop: it must be seen in the log, and must not come to a decoder as a
#            frame that no device sent. A search for error frames in a recorded dive finds none.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check python-can==4.6.1
cat >"$place/bus.log" <<'END'
(1700000000.000000) can0 20000040#0000000000000000
(1700000000.100000) can0 20000004#0004000000000000
(1700000000.200000) can0 20000088#0000040000000000
END
"$place/venv/bin/python" - "$place/bus.log" <<'END'
import sys

import can

with can.CanutilsLogReader(sys.argv[1]) as log:
    read = [(frame.is_error_frame, frame.is_extended_id, frame.arbitration_id, frame.dlc) for frame in log]
if read != [(False, True, 0x40, 8), (False, True, 0x4, 8), (True, True, 0, 0)]:
    sys.exit(f"changed: three error frames are read as (error, extended, id, length) {read}")
print(f"as before: three error frames are read as (error, extended, id, length) {read}")
END
