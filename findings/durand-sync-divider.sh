#!/bin/sh
# durand sends a PDO of "every n-th SYNC" at every SYNC, once the first n are over.
#
# Version:   durand 0.5.0 (python-can 4.6.1)
# Behaviour: a transmit PDO of transmission type 2 to 240 counts SYNCs and never starts its count again.
# Seen:      transmission type 5, 20 SYNCs: sent at the 5th, 6th, 7th, ... 20th
# Expected:  at the 5th, 10th, 15th and 20th: by CiA 301 a value n of 1 to 240 means that the PDO is sent at every n-th
#            SYNC.
# Matters:   a depth sensor set to a fifth of the SYNCs, so that the bus carries it beside an INS at 100 Hz, sends five
#            times as much. One who pairs it with every fifth epoch of the INS, by counting, pairs it with a wrong one.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check durand==0.5.0 python-can==4.6.1
"$place/venv/bin/python" - <<'END'
import sys

from durand import DatatypeEnum, MinimalNode, Variable
from durand.network import NetworkABC
from durand.services.nmt import StateEnum

SYNC, PDO, NODE = 0x80, 0x185, 5


class Bus(NetworkABC):
    """Hands on what is sent to a list, and what is received to the node."""

    def __init__(self):
        self.subscribed, self.sent = {}, []

    def add_subscription(self, cob_id, callback):
        self.subscribed[cob_id] = callback

    def remove_subscription(self, cob_id):
        del self.subscribed[cob_id]

    def send(self, cob_id, msg):
        self.sent.append(cob_id)


def sent_at(transmission_type):
    """Return at which of 20 SYNCs the PDO is sent."""
    bus = Bus()
    node = MinimalNode(bus, NODE)
    node.object_dictionary[0x2000] = Variable(DatatypeEnum.UNSIGNED16, "rw", 7, name="depth")
    node.tpdo[0].mapping = [(0x2000, 0)]
    node.tpdo[0].transmission_type = transmission_type
    node.nmt.set_state(StateEnum.OPERATIONAL)
    numbers = []
    for number in range(1, 21):
        bus.sent.clear()
        bus.subscribed[SYNC](SYNC, b"")
        numbers += [number] * bus.sent.count(PDO)
    return numbers


seen = {1: sent_at(1), 5: sent_at(5)}
if seen != {1: list(range(1, 21)), 5: list(range(5, 21))}:
    sys.exit(f"changed: SYNCs at which the PDO is sent, by transmission type: {seen}")
print(f"as before: SYNCs at which the PDO is sent, by transmission type: {seen}")
END
