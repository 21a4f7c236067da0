#!/bin/sh
# pyxtf gives raw positions (type 107) a fraction of a second that is 100 times too small.
#
# Version:   pyxtf 1.5.0 (numpy 2.4.6)
# Behaviour: XTFPosRawNavigation.get_time() adds the two-byte field `Microsecond` as microseconds.
# Seen:      a fix at 12:00:05.3 (field = 3000) is given as 12:00:05.003
# Expected:  12:00:05.300. The XTF specification has this field of XTFPOSRAWNAVIGATION as 0 to 9999, in tenths of a
#            millisecond, though its name says microseconds; two bytes could not hold the microseconds of a second.
#            (In XTFHEADERNAVIGATION and XTFHEADERGYRO the field is four bytes long and is microseconds.)
# Matters:   positions are up to 0.99 s too early beside the pings of the same file: at 2 m/s a recorded obstacle is put
#            2 m from where it was, and the error jumps back once a second, which looks like a noisy track.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check pyxtf==1.5.0 numpy==2.4.6
"$place/venv/bin/python" - "$place/fixes.xtf" <<'END'
import sys

import numpy as np
import pyxtf

fix = pyxtf.XTFPosRawNavigation()
fix.Year, fix.Month, fix.Day, fix.Hour, fix.Minute, fix.Second = 2026, 3, 1, 12, 0, 5
fix.Microsecond = 3000  # 0.3 s in tenths of a millisecond
fix.NumBytesThisRecord = 64
with open(sys.argv[1], "wb") as file:
    file.write(pyxtf.XTFFileHeader().to_bytes())
    file.write(fix.to_bytes())

_, packets = pyxtf.xtf_read(sys.argv[1])
(read,) = packets[pyxtf.XTFHeaderType.pos_raw_navigation]
if read.get_time() != np.datetime64("2026-03-01T12:00:05.003"):
    sys.exit(f"changed: a fix at 12:00:05.3 is given as {read.get_time()}, no longer as 12:00:05.003")
print(f"as before: a fix at 12:00:05.3 is given as {read.get_time()}")
END
