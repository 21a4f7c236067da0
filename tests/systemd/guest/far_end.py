"""In the guest: an INS at rest on can0 and a SeaBat behind /dev/ttyUSB0, which plays recorded pings in a loop."""

import shutil
import sys
import threading
import time
from itertools import count, cycle
from pathlib import Path

import can
import msgspec

from ods.base import clock
from ods.sim_sonar.device.lines.serial_line import SerialLine
from ods.sim_sonar.ins.canopen_ins import SimulatedIns
from ods.sonar_link.files.opening import open_pings
from ods.sonar_link.s7k.records import ping_records

POSITION_NED, LEVEL, AT_REST = (0.0, 0.0, 4.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
POSE_PERIOD_S, PING_PERIOD_S = 0.02, 0.5


def send_poses(ins: SimulatedIns) -> None:
    """Send the one pose for ever, as an INS does: whether anybody listens or not."""
    due_s = time.monotonic()
    while True:
        ins.send(clock.utc_ns() // clock.MS * clock.MS, POSITION_NED, LEVEL, AT_REST)
        due_s = max(due_s + POSE_PERIOD_S, time.monotonic())
        time.sleep(max(0.0, due_s - time.monotonic()))


def main(recording: Path, device: Path) -> None:
    """Play both until killed."""
    pings = list(open_pings(recording).pings)
    line = SerialLine(device)
    shutil.chown(device, group="dialout")  # as serial adapters are
    device.chmod(0o660)
    ins = SimulatedIns(can.Bus(interface="socketcan", channel="can0"), Path("/etc/ods/ins.eds"))
    threading.Thread(target=send_poses, args=(ins,), daemon=True).start()
    for number, ping in zip(count(), cycle(pings)):
        now_ns = clock.utc_ns()
        line.write(ping_records(msgspec.structs.replace(ping, ping_number=number, utc_ns=now_ns)), PING_PERIOD_S)
        time.sleep(max(0.0, PING_PERIOD_S - (clock.utc_ns() - now_ns) / clock.NS))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
