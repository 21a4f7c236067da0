#!/bin/sh
# eds-utils' DCF says that a device takes dummy entries in its PDOs, whatever its EDS says.
#
# Version:   eds-utils 0.3.1; read by canopen 2.4.1 (python-can 4.6.1)
# Behaviour: [DummyUsage] is not read, and written with 1 for Dummy0000 to Dummy0007; the lines of [Comments] are
#            dropped. eds2dcf and eds-autofix, which write so, say nothing of it.
# Seen:      an EDS with Dummy0001 to Dummy0007 = 0: canopen has no dummy objects; its DCF by eds2dcf: 1 to 7
# Expected:  what the EDS says: by CiA 306-1 the section tells which of the data types 1 to 7 may be mapped as a gap.
# Matters:   a program that fills gaps of a receive PDO with dummy entries, as CiA 301 allows, plans for a device that
#            refuses them: the mapping ends with an SDO abort, on board and not at the desk.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check eds-utils==0.3.1 canopen==2.4.1 python-can==4.6.1
"$place/venv/bin/python" - "$place" <<'END'
import subprocess
import sys
from pathlib import Path

import canopen

DUMMIES = range(1, 8)
OBJECT = "[{0}]\nParameterName={1}\nObjectType=0x7\nDataType=0x{2:04X}\nAccessType=ro\nDefaultValue=0\nPDOMapping=0"
SECTIONS = (
    "[FileInfo]\nFileName=depth.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\nDescription=depth sensor\n"
    "CreationTime=12:00PM\nCreationDate=11-30-2026\nCreatedBy=a maker\n"
    "ModificationTime=12:00PM\nModificationDate=11-30-2026\nModifiedBy=a maker",
    "[DeviceInfo]\nVendorName=a maker\nVendorNumber=0\nProductName=depth sensor\nProductNumber=0\nRevisionNumber=0\n"
    "OrderCode=0\n" + "".join(f"BaudRate_{rate}=1\n" for rate in (10, 20, 50, 125, 250, 500, 800, 1000))
    + "SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=8\nDynamicChannelsSupported=0\nGroupMessaging=0\n"
    "NrOfRXPDO=0\nNrOfTXPDO=0\nLSS_Supported=0",
    "[DummyUsage]\n" + "\n".join(f"Dummy{number:04}=0" for number in DUMMIES),
    "[Comments]\nLines=1\nLine1=The depth is from the pressure.",
    "[MandatoryObjects]\nSupportedObjects=3\n1=0x1000\n2=0x1001\n3=0x1018",
    OBJECT.format("1000", "Device type", 7),
    OBJECT.format("1001", "Error register", 5),
    "[1018]\nParameterName=Identity object\nObjectType=0x9\nSubNumber=2",
    OBJECT.format("1018sub0", "Highest sub-index supported", 5).replace("Value=0", "Value=1"),
    OBJECT.format("1018sub1", "Vendor-ID", 7),
    "[OptionalObjects]\nSupportedObjects=0",
    "[ManufacturerObjects]\nSupportedObjects=0",
)
place = Path(sys.argv[1])
eds, dcf = place / "depth.eds", place / "depth.dcf"
eds.write_text("\n\n".join(SECTIONS) + "\n")
made = subprocess.run(
    [place / "venv/bin/eds2dcf", eds, "5", "depth", "--output", dcf], capture_output=True, text=True, check=True
)


def dummies(file):
    dictionary = canopen.import_od(str(file), node_id=5)
    return [number for number in DUMMIES if number in dictionary]


seen = {"EDS": dummies(eds), "DCF": dummies(dcf), "said": made.stdout + made.stderr}
if seen != {"EDS": [], "DCF": list(DUMMIES), "said": ""} or "Line1" in dcf.read_text():
    sys.exit(f"changed: dummy objects: {seen}")
print(f"as before: dummy objects: {seen}")
END
