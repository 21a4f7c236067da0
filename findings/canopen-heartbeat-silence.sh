#!/bin/sh
# canopen goes on calling a node OPERATIONAL after its heartbeat has stopped.
#
# Version:   canopen 2.4.1 (python-can 4.6.1)
# Behaviour: nmt.state is the state of the last heartbeat, however old; the node's producer heartbeat time (0x1017) and
#            the consumer heartbeat time (0x1016) in the object dictionary are not looked at.
# Seen:      one heartbeat, then nothing for ten times the time of 0x1017: OPERATIONAL
# Expected:  an error or an unknown state: by CiA 301 a consumer reports a heartbeat event when no heartbeat came
#            within its heartbeat consumer time. (The library leaves it to the caller: wait_for_heartbeat() and
#            nmt.timestamp are there.)
# Matters:   an INS that lost its power looks healthy to a supervisor that asks for the state; silence must be measured
#            by whoever depends on the poses.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check canopen==2.4.1 python-can==4.6.1
"$place/venv/bin/python" - <<'END'
import sys
import time

import can
import canopen
from canopen.objectdictionary import UNSIGNED8, UNSIGNED16, UNSIGNED32, ODArray, ODVariable, ObjectDictionary

PERIOD_S = 0.05


def variable(index, subindex, data_type, default):
    made = ODVariable(f"{index:X} {subindex}", index, subindex)
    made.data_type, made.default = data_type, default
    return made


objects = ObjectDictionary()
objects.add_object(variable(0x1017, 0, UNSIGNED16, int(1000 * PERIOD_S)))
consumer = ODArray("consumer heartbeat time", 0x1016)
consumer.add_member(variable(0x1016, 0, UNSIGNED8, 1))
consumer.add_member(variable(0x1016, 1, UNSIGNED32, 5 << 16 | int(2000 * PERIOD_S)))
objects.add_object(consumer)

network = canopen.Network()
network.connect(interface="virtual", channel="finding")
device = can.Bus(interface="virtual", channel="finding")
try:
    node = network.add_node(5, objects)
    device.send(can.Message(arbitration_id=0x705, is_extended_id=False, data=[5]))
    until = time.monotonic() + 5.0
    while node.nmt.state != "OPERATIONAL" and time.monotonic() < until:
        time.sleep(0.01)
    alive = node.nmt.state
    time.sleep(10 * PERIOD_S)
    silent = node.nmt.state
finally:
    device.shutdown()
    network.disconnect()
if (alive, silent) != ("OPERATIONAL", "OPERATIONAL"):
    sys.exit(f"changed: with a heartbeat {alive}, ten heartbeat times later {silent}")
print(f"as before: with a heartbeat {alive}, ten heartbeat times later {silent}")
END
