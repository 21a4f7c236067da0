#!/bin/sh
# python-can's CSV and SQLite logs forget who sent a frame, on which bus, and whether it was CAN FD.
#
# Version:   python-can 4.6.1
# Behaviour: both formats have no column for direction, channel and CAN FD; what is read back has the defaults, and
#            nothing is said at writing.
# Seen:      a transmitted CAN FD frame of 12 bytes on can1, written and read back: received, no channel, not FD, yet
#            12 bytes long (a classic frame has 8 at most)
# Expected:  what was written, or a word: the documentation lists the columns, and nobody warns at run time. BLF and
#            candump logs of the same library keep it; its TRC writer warns about each frame that it cannot write.
# Matters:   a log that is played back to a CAN node then also plays the node's own heartbeats and requests to it as
#            if others had sent them, and frames of two buses with the same identifier (two INSs) become one stream.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check python-can==4.6.1
"$place/venv/bin/python" - "$place" <<'END'
import sys

import can

FIELDS = ("is_rx", "channel", "is_fd", "bitrate_switch", "dlc")
sent = can.Message(
    timestamp=1_700_000_000.0, arbitration_id=0x181, is_extended_id=False, is_fd=True, bitrate_switch=True,
    data=range(12), is_rx=False, channel="can1",
)


def read_back(ending):
    path = f"{sys.argv[1]}/bus.{ending}"
    with can.Logger(path) as log:
        log.on_message_received(sent)
    (frame,) = can.LogReader(path)
    return tuple(getattr(frame, field) for field in FIELDS)


lost = (True, None, False, False, 12)
kept = (False, "can1", True, True, 12)
seen = {ending: read_back(ending) for ending in ("csv", "db", "log")}
if seen != {"csv": lost, "db": lost, "log": kept}:
    sys.exit(f"changed: {FIELDS} of {kept} are read back as {seen}")
print(f"as before: {FIELDS} of {kept} are read back as {seen}")
END
