#!/bin/sh
# oculus-python writes pings of an Oculus log into January 1970 when it converts the log to ViewPoint's newer form.
#
# Version:   oculus-python 0.0.2a1 (numpy 1.26.4, opencv-python-headless 4.11.0.86, netCDF4 1.7.2, rosbags 0.11.9)
# Behaviour: the SQLite form (.oculus, version 2) has times in milliseconds, and its reader divides by 1000; the writer
#            of the same package puts the seconds of the older form into that column.
# Seen:      a ping of 2026-11-30 12:00:00.25 (version 1), converted by `--output bpsv2` and read again: 1970-01-21
#            18:54:00.0
# Expected:  the same time, as after a conversion to version 1. (The conversion is called experimental.)
# Matters:   intervals shrink by 1000 as well: 8 pings a second become 8000, a second's turn is over in a millisecond,
#            and no pose of the dive belongs to any ping.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==1.26.4 opencv-python-headless==4.11.0.86 netCDF4==1.7.2 rosbags==0.11.9
"$place/venv/bin/pip" install --quiet --disable-pip-version-check --no-deps oculus-python==0.0.2a1
"$place/venv/bin/python" -W ignore - "$place/dive.oculus" <<'END'
import sys
from datetime import UTC, datetime
from pathlib import Path

from bps_oculus import io
from bps_oculus import oculus as messages
from bps_oculus.logger import v1

BEAMS, LINES = 4, 5
TIME_S = datetime(2026, 11, 30, 12, 0, 0, 250_000, UTC).timestamp()
HEADER_BYTES, RESULT_BYTES = messages.OculusMessageHeader.size(), messages.OculusSimplePingResult2.size()
IMAGE_AT = RESULT_BYTES + 2 * BEAMS
SIZE = IMAGE_AT + BEAMS * LINES

header = messages.OculusMessageHeader(messages.OCULUS_CHECK_ID, 1, 0, 0x23, 2, SIZE - HEADER_BYTES, 0)
rate, sample = messages.PingRateType.pingRateNormal, messages.DataSizeType.dataSize8Bit
fire = messages.OculusSimpleFireMessage2(header, 1, rate, 255, 255, 0x19, 10.0, 50.0, 1500.0, 35.0, 0, (0,) * 8)
result = messages.OculusSimplePingResult2(
    fire, 7, 0, 750e3, 10.0, 1.0, 0.0, 0.0, 0.0, 1500.0, 12.5, sample, 0.1, LINES, BEAMS, 0, 0, 0, 0,
    IMAGE_AT, BEAMS * LINES, SIZE,
)
message = result.pack() + bytes(2 * BEAMS) + bytes(BEAMS * LINES)
item = v1.RmLogItem(v1.s_itemHeader, v1.RmLogItem.size(), 10, 0, TIME_S, 0, SIZE, SIZE)
head = v1.RmLogHeader(v1.s_fileHeader, v1.RmLogHeader.size(), "Oculus", 1, 0, 0, TIME_S)
log = Path(sys.argv[1])
log.write_bytes(head.pack() + item.pack() + message)


def time_of(path, importer):
    ((info, *_),) = importer(path).generate()
    return datetime.fromtimestamp(info.timestamp, UTC).strftime("%Y-%m-%d %H:%M:%S.%f")[:-5]


for convert in (io.to_bpsv1, io.to_bpsv2):
    list(convert(io.ImporterV1(log), log))
seen = {
    "version 1": time_of(log, io.ImporterV1),
    "converted to version 1": time_of(log.with_suffix(".v1.oculus"), io.ImporterV1),
    "converted to version 2": time_of(log.with_suffix(".v2.oculus"), io.ImporterV2),
}
right = "2026-11-30 12:00:00.2"
expected = {"version 1": right, "converted to version 1": right, "converted to version 2": "1970-01-21 18:54:00.0"}
if seen != expected:
    sys.exit(f"changed: {seen}")
print(f"as before: {seen}")
END
