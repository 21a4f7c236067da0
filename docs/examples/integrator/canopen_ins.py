"""A simulated INS that speaks CANopen with the objects of config/ins.eds: 20 poses a second, python-can only.

python canopen_ins.py vcan0 START_S
"""

import struct
import sys
import time

import can
import vehicle

NODE = 5
PERIOD_S = 0.05
DAY_MS = 86_400_000
DAYS_1970_TO_1984 = 5113
ALL_VALID = 0b1111
"""Position, attitude, velocity, time of day."""
OPERATIONAL = 5


def pdos(sequence: int, now: vehicle.State) -> list[tuple[int, bytes]]:
    """Return COB-IDs and contents of the six PDOs of one instant."""
    north, east, down = (round(1000.0 * part) for part in now.ned)
    forward, starboard, below = (round(1000.0 * part) for part in vehicle.to_body(now.velocity_ned))
    roll, pitch, yaw = (round(1e4 * angle) for angle in (vehicle.ROLL, vehicle.PITCH, vehicle.HEADING))
    return [
        (0x180 + NODE, struct.pack("<BB", sequence, ALL_VALID) + time_of_day()),
        (0x280 + NODE, struct.pack("<ii", north, east)),
        (0x380 + NODE, struct.pack("<iB", down, sequence)),
        (0x480 + NODE, struct.pack("<hhhB", roll, pitch, yaw, sequence)),
        (0x680 + NODE, struct.pack("<hhhB", forward, starboard, below, sequence)),
        (0x6A0 + NODE, struct.pack("<HHBHB", 200, 100, 2, 50, sequence)),
    ]


def time_of_day() -> bytes:
    """Return milliseconds since midnight and days since 1984-01-01, UTC."""
    days, milliseconds = divmod(time.time_ns() // 1_000_000, DAY_MS)
    return struct.pack("<IH", milliseconds, days - DAYS_1970_TO_1984)


def main(channel: str, start_s: float) -> None:
    """Send until killed."""
    with can.Bus(channel, "socketcan") as bus:

        def send(can_id: int, data: bytes) -> None:
            bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False), timeout=0.1)

        for count in range(2**62):
            if count % 4 == 0:
                send(0x700 + NODE, bytes([OPERATIONAL]))  # heartbeat
            if count % 20 == 0:
                send(0x100, time_of_day())  # TIME
            send(0x080, b"")  # SYNC
            for can_id, data in pdos(count % 256, vehicle.state(start_s)):
                send(can_id, data)
            time.sleep(PERIOD_S)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
