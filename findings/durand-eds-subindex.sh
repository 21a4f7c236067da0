#!/bin/sh
# durand's EDS has sub-index 10 of an object as 16.
#
# Version:   durand 0.5.0 (python-can 4.6.1); read by canopen 2.4.1
# Behaviour: `node.eds`, also what the node gives as object 0x1021, names the sections of sub-objects by the decimal
#            number, [2001sub10].
# Seen:      a record of 12 entries: canopen finds sub-indices 0 to 9 and 16 to 18; the node answers to 0 to 12
# Expected:  [2001subA], [2001subB], [2001subC]: CiA 306-1 writes index and sub-index of a section's name as hexadecimal
#            numbers without 0x.
# Matters:   settings and values beyond the ninth of a record cannot be read by the node's own EDS; a PDO that maps
#            sub-index 10 names an object that the EDS lacks.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check durand==0.5.0 canopen==2.4.1 python-can==4.6.1
"$place/venv/bin/python" - "$place/node.eds" <<'END'
import sys
from pathlib import Path

import canopen
from durand import DatatypeEnum, MinimalNode, Record, Variable
from durand.network import NetworkABC


class Nowhere(NetworkABC):
    """A bus without other nodes."""

    def add_subscription(self, cob_id, callback):
        pass

    def remove_subscription(self, cob_id):
        pass

    def send(self, cob_id, msg):
        pass


node = MinimalNode(Nowhere(), 5)
record = Record(name="sensors")
for number in range(1, 13):
    record[number] = Variable(DatatypeEnum.UNSIGNED16, "ro", 0, name=f"sensor {number}")
node.object_dictionary[0x2001] = record
node.object_dictionary[0x2002] = Variable(DatatypeEnum.UNSIGNED16, "ro", 0, name="status")

file = Path(sys.argv[1])
file.write_text(node.eds.content)
read = canopen.import_od(str(file), node_id=5)
seen = {entry.name: number for number, entry in read[0x2001].subindices.items() if number}
own = {entry.name: number for number, entry in node.object_dictionary[0x2001] if number}
right = {f"sensor {number}": number for number in range(1, 13)}
if own != right or seen != right | {"sensor 10": 16, "sensor 11": 17, "sensor 12": 18}:
    sys.exit(f"changed: sub-indices by the node: {own}; by its EDS: {seen}")
print(f"as before: sub-indices by the node: {own}; by its EDS: {seen}")
END
