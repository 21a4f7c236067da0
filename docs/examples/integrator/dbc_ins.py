"""A simulated INS of awkward habits: awkward.dbc, 29-bit identifiers, Motorola byte order, body forward, left, up in
east, north, up, km/h, and a clock that is sent first with the highest identifier. 20 poses a second, python-can only.

python dbc_ins.py vcan0 START_S
"""

import math
import struct
import sys
import time

import can
import vehicle

CLOCK, ATTITUDE, POSITION, HEIGHT, VELOCITY = 0x18FF01F0, 0x18FF0101, 0x18FF0102, 0x18FF0103, 0x18FF0104
PERIOD_S = 0.05
KMH = 3.6
"""km/h in a m/s."""


def frames(now: vehicle.State) -> list[tuple[int, bytes]]:
    """Return identifiers and contents of the five messages of one instant, in the order of sending."""
    north, east, down = (round(1000.0 * part) for part in now.ned)
    v_north, v_east, v_down = (round(100.0 * KMH * part) for part in now.velocity_ned)
    # from forward, starboard, down in north, east, down to forward, left, up in east, north, up
    roll, pitch, yaw = vehicle.ROLL, -vehicle.PITCH, math.pi / 2.0 - vehicle.HEADING
    return [
        (CLOCK, struct.pack(">I", time.monotonic_ns() // 1_000_000 % 2**32)),
        (ATTITUDE, struct.pack(">hhh", *(round(1e4 * angle) for angle in (roll, pitch, yaw)))),
        (POSITION, struct.pack(">ii", east, north)),
        (HEIGHT, struct.pack(">i", -down)),
        (VELOCITY, struct.pack(">hhh", v_east, v_north, -v_down)),
    ]


def main(channel: str, start_s: float) -> None:
    """Send until killed."""
    with can.Bus(channel, "socketcan") as bus:
        while True:
            for can_id, data in frames(vehicle.state(start_s)):
                bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=True), timeout=0.1)
            time.sleep(PERIOD_S)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
