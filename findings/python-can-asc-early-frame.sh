#!/bin/sh
# python-can writes a frame that is older than the first one into an ASC log at 1.7 thousand million seconds.
#
# Version:   python-can 4.6.1
# Behaviour: ASCWriter subtracts the log's start from each stamp, but only where the stamp is not before the start. A
#            frame that is 2 ms older than the first frame keeps its stamp since 1970 among stamps since the start.
# Seen:      stamps read back by ASCReader: 0.0, 0.1, 1700000000.498, 0.2
# Expected:  0.0, 0.1, 0.1, 0.2: the class's documentation says that a stamp before the previous one is replaced by the
#            previous one. (CanutilsLogWriter does so; TRCWriter writes -2 ms.)
# Matters:   frames of two adapters, or of a kernel and a user-space queue, arrive out of order by milliseconds as a
#            matter of course. One such pose makes a recording 54 years long: a player waits, and what interpolates
#            poses between its neighbours has lost its time axis.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check python-can==4.6.1
"$place/venv/bin/python" - "$place/bus.asc" <<'END'
import sys

import can

START = 1_700_000_000.5
with can.ASCWriter(sys.argv[1]) as log:
    for after in (0.0, 0.1, -0.002, 0.2):
        frame = can.Message(timestamp=START + after, arbitration_id=0x181, is_extended_id=False, data=[1])
        log.on_message_received(frame)

with can.ASCReader(sys.argv[1]) as log:
    read = [frame.timestamp for frame in log]
if read != [0.0, 0.1, 1_700_000_000.498, 0.2]:
    sys.exit(f"changed: stamps are read back as {read}")
print(f"as before: stamps are read back as {read}")
END
