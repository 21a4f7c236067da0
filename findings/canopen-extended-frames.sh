#!/bin/sh
# canopen takes a 29-bit frame for the PDO or heartbeat that has the same number in 11 bits.
#
# Version:   canopen 2.4.1 (python-can 4.6.1)
# Behaviour: the listener hands on an identifier's number and drops whether it has 11 or 29 bits.
# Seen:      after a PDO 0x185 with depth 100, an extended frame 0x00000185 of another protocol: depth 999; an
#            extended frame 0x00000705 puts the node into state OPERATIONAL
# Expected:  depth stays 100 and the state what it was: CiA 301 has its predefined connection set in 11-bit identifiers,
#            and CAN treats the two as different identifiers (ISO 11898-1).
# Matters:   INSs with a DBC of their own, thrusters and batteries share a vehicle's bus, some with small 29-bit
#            identifiers. A pose must not come from a frame that is not the INS's, nor a dead INS look alive.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check canopen==2.4.1 python-can==4.6.1
"$place/venv/bin/python" - <<'END'
import struct
import sys
import threading

import can
import canopen
from canopen.objectdictionary import INTEGER32, ObjectDictionary, ODVariable

depth = ODVariable("depth", 0x2000)
depth.data_type = INTEGER32
objects = ObjectDictionary()
objects.add_object(depth)

network = canopen.Network()
network.connect(interface="virtual", channel="finding")
other = can.Bus(interface="virtual", channel="finding")
try:
    node = network.add_node(5, objects)
    pdo = canopen.pdo.PdoMap(node.tpdo, None, None)
    pdo.cob_id = 0x185
    pdo.add_variable(0x2000, length=32)
    network.subscribe(pdo.cob_id, pdo.on_message)

    came = threading.Event()
    network.subscribe(0x7F0, lambda number, data, stamp: came.set())

    def after(number, extended, data):
        other.send(can.Message(arbitration_id=number, is_extended_id=extended, data=data))
        other.send(can.Message(arbitration_id=0x7F0, is_extended_id=False, data=[0]))  # in order behind it
        if not came.wait(5.0):
            sys.exit("changed: frames do not come at all")
        came.clear()

    after(0x185, False, struct.pack("<i", 100))
    first = pdo["depth"].raw
    after(0x185, True, struct.pack("<i", 999))
    before = node.nmt.state
    after(0x705, True, [5])
    seen = (first, pdo["depth"].raw, before, node.nmt.state)
finally:
    other.shutdown()
    network.disconnect()
if seen[:2] != (100, 999) or seen[2] == seen[3] or seen[3] != "OPERATIONAL":
    sys.exit(f"changed: depth before and after a 29-bit frame, state before and after another: {seen}")
print(f"as before: depth before and after a 29-bit frame, state before and after another: {seen}")
END
