#!/bin/sh
# canopen decodes the rest of a PDO from wrong bits if the mapping names an object that the EDS lacks.
#
# Version:   canopen 2.4.1 (python-can 4.6.1)
# Behaviour: tpdo.read() leaves out a mapped object that is not in the object dictionary, with one log line (said not to
#            be found), and places the following ones as if it had no bits.
# Seen:      a device maps [status: 16 bits, heading: 32 bits] and sends status 7, heading 1234; read by an EDS without
#            the status: heading 80871431
# Expected:  1234, or no value. CiA 301 has the bit length in each mapping entry, so the place of what follows is known
#            without the object; canopen itself keeps the place of dummy entries (index 1 to 7).
# Matters:   an INS with a newer firmware than the EDS at hand gives a heading that is a number, changes, and is wrong.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check canopen==2.4.1 python-can==4.6.1
"$place/venv/bin/python" - <<'END'
import logging
import struct
import sys

import canopen
from canopen.objectdictionary import INTEGER32, UNSIGNED8, UNSIGNED16, UNSIGNED32
from canopen.objectdictionary import ObjectDictionary, ODRecord, ODVariable

logging.disable()
STATUS, HEADING = 0x2100, 0x2000


def variable(name, index, subindex, data_type, default=0):
    made = ODVariable(name, index, subindex)
    made.data_type, made.default, made.access_type = data_type, default, "rw"
    return made


def record(name, index, members):
    made = ODRecord(name, index)
    for subindex, (data_type, default) in enumerate(members):
        made.add_member(variable(f"{name} {subindex}", index, subindex, data_type, default))
    return made


def dictionary(*objects):
    made = ObjectDictionary()
    made.add_object(record("TPDO", 0x1800, [(UNSIGNED8, 2), (UNSIGNED32, 0x185), (UNSIGNED8, 255)]))
    mapping = [(UNSIGNED8, 2), (UNSIGNED32, STATUS << 16 | 16), (UNSIGNED32, HEADING << 16 | 32)]
    made.add_object(record("TPDO mapping", 0x1A00, mapping))
    for one in objects:
        made.add_object(one)
    return made


heading = variable("heading", HEADING, 0, INTEGER32)
status = variable("status", STATUS, 0, UNSIGNED16)
device, reader = canopen.Network(), canopen.Network()
device.connect(interface="virtual", channel="finding")
reader.connect(interface="virtual", channel="finding")
device.create_node(5, dictionary(status, heading))
node = reader.add_node(5, dictionary(heading))
try:
    node.tpdo.read()
    node.tpdo[1].subscribe()
    device.send_message(0x185, struct.pack("<Hi", 7, 1234))
    if node.tpdo[1].wait_for_reception(timeout=5.0) is None:
        sys.exit("changed: the PDO did not come at all")
    seen = {one.name: one.raw for one in node.tpdo[1].map}
finally:
    device.disconnect()
    reader.disconnect()
if seen != {"heading": struct.unpack_from("<i", struct.pack("<Hi", 7, 1234))[0]}:
    sys.exit(f"changed: status 7, heading 1234 by an EDS without the status: {seen}")
print(f"as before: status 7, heading 1234 by an EDS without the status: {seen}")
END
