#!/bin/sh
# cantools passes over every frame of a candump log that says whether a frame was sent or received.
#
# Version:   cantools 45.1.0
# Behaviour: logreader and `cantools decode` know candump's lines with and without stamps, but not those of
#            `candump -x`, which have RX or TX and two flags behind the channel; such lines are no frames
#            to them, without a word.
# Seen:      three frames by `candump -t a`: three depths; the same by `candump -t a -x`: none, and exit status 0
# Expected:  three depths, or an error: the documentation offers `candump | cantools decode` and a reader of candump's
#            formats, and -x is candump's option for "extra message infos".
# Matters:   the log of a sea trial decodes to nothing and looks like an INS that was silent.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check cantools==45.1.0
cat >"$place/ins.dbc" <<'END'
VERSION ""
NS_ :
BS_ :
BU_: INS
BO_ 304 DEPTH: 4 INS
 SG_ Depth : 0|32@1- (0.001,0) [0|0] "m" INS
END
cat >"$place/plain.log" <<'END'
 (1700000000.000000)  can0  130   [4]  D2 04 00 00
 (1700000000.100000)  can0  130   [4]  D2 04 00 00
 (1700000000.200000)  can0  130   [4]  D2 04 00 00
END
cat >"$place/extra.log" <<'END'
 (1700000000.000000)  can0  RX - -  130   [4]  D2 04 00 00
 (1700000000.100000)  can0  RX - -  130   [4]  D2 04 00 00
 (1700000000.200000)  can0  TX - -  130   [4]  D2 04 00 00
END
depths() {
    "$place/venv/bin/python" -m cantools decode "$place/ins.dbc" <"$1" >"$place/decoded"
    grep -c "Depth: 1.234 m" "$place/decoded" || true
}
seen="$(depths "$place/plain.log") of 3 without -x, $(depths "$place/extra.log") of 3 with -x"
if [ "$seen" != "3 of 3 without -x, 0 of 3 with -x" ]; then
    echo "changed: depths decoded from candump's lines: $seen" >&2
    exit 1
fi
echo "as before: depths decoded from candump's lines: $seen"
