#!/bin/sh
# pynmeagps gives no time for a sentence whose seconds have more than six decimals.
#
# Version:   pynmeagps 1.1.8
# Behaviour: the time field is read with a format of at most six decimals; longer ones become an empty string, without
#            an error.
# Seen:      120000.123456 is 12:00:00.123456, 120000.1234567 is ''
# Expected:  12:00:00.123456 (pynmea2 1.19.0 cuts), or an error. NMEA 0183 lets the fraction of a second have any number
#            of digits.
# Matters:   an INS set to 100 ns sends poses without a time, and what stamps a pose at reception when the time is
#            missing does so from then on: 20 ms late at 20 degrees a second is 0.35 m at 50 m.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check pynmeagps==1.1.8
"$place/venv/bin/python" - <<'END'
import sys
from functools import reduce

from pynmeagps import NMEAReader


def time_of(fraction):
    body = f"GPRMC,120000.{fraction},A,4916.45,N,12311.12,W,000.5,054.7,311226,020.3,E"
    checksum = reduce(lambda sum_, letter: sum_ ^ ord(letter), body, 0)
    return str(NMEAReader.parse(f"${body}*{checksum:02X}\r\n").time)


seen = [time_of("123456"), time_of("1234567")]
if seen != ["12:00:00.123456", ""]:
    sys.exit(f"changed: times with six and seven decimals: {seen}")
print(f"as before: times with six and seven decimals: {seen}")
END
