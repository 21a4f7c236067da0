"""An INS made by hand from docs/navigation/dbc.md: its DBC file, its frames, and the truth behind each pose.

Five messages an instant; each number of instant n tells n, so that a pose of two instants shows.
"""

import math
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random
from typing import NamedTuple

from ods.messages import Pose
from ods.nav_bridge.settings import DbcSettings, SignalSettings

TEXT = """VERSION ""
BU_: INS
BO_ 1792 CLOCK: 8 INS
 SG_ US : 0|32@1+ (1,0) [0|0] "us" INS
 SG_ COUNT : 32|8@1+ (1,0) [0|0] "" INS
BO_ 272 PLACE: 8 INS
 SG_ N : 0|24@1- (0.01,0) [0|0] "m" INS
 SG_ E : 24|24@1- (0.01,0) [0|0] "m" INS
 SG_ COUNT : 48|8@1+ (1,0) [0|0] "" INS
BO_ 768 DEPTH: 4 INS
 SG_ D : 0|16@1- (0.01,0) [0|0] "m" INS
 SG_ COUNT : 16|8@1+ (1,0) [0|0] "" INS
BO_ 1536 TURN: 8 INS
 SG_ R : 0|16@1- (0.0001,0) [0|0] "rad" INS
 SG_ P : 16|16@1- (0.0001,0) [0|0] "rad" INS
 SG_ Y : 32|16@1- (0.0001,0) [0|0] "rad" INS
 SG_ COUNT : 48|8@1+ (1,0) [0|0] "" INS
BO_ 1024 SPEED: 8 INS
 SG_ U : 0|16@1- (0.001,0) [0|0] "m/s" INS
 SG_ V : 16|16@1- (0.001,0) [0|0] "m/s" INS
 SG_ W : 32|16@1- (0.001,0) [0|0] "m/s" INS
 SG_ COUNT : 48|8@1+ (1,0) [0|0] "" INS
"""
IDS = {"CLOCK": 0x700, "PLACE": 0x110, "DEPTH": 0x300, "TURN": 0x600, "SPEED": 0x400}
SIGNALS: dict[str, str | SignalSettings] = {
    "north": "PLACE.N", "east": "PLACE.E", "down": "DEPTH.D", "roll": "TURN.R", "pitch": "TURN.P", "yaw": "TURN.Y",
    "u": "SPEED.U", "v": "SPEED.V", "w": "SPEED.W",
}  # fmt: skip
NS, MS = 1_000_000_000, 1_000_000
FIRST_US = 7_000_000


class Sent(NamedTuple):
    """A frame on its way."""

    t_ns: int
    can_id: int
    data: bytes


class Manner(NamedTuple):
    """How an INS sends, and what the bus makes of it."""

    order: Sequence[str] = tuple(IDS)
    rate_hz: float = 100.0
    frame_ns: int = 250_000
    jitter_ns: int = 0
    """Of each frame."""
    delayed: float = 0.0
    """Share of the bursts that are held up, all or from one frame on, by half a period at most."""
    lost: float = 0.0
    """Share of the frames that never arrive."""


def settings(folder: Path, **changes: object) -> DbcSettings:
    """Write the DBC file and return the usual map."""
    file = folder / "handmade.dbc"
    file.write_text(TEXT)
    return DbcSettings(**({"file": file, "signals": SIGNALS, "time": "CLOCK.US"} | changes))  # type: ignore[arg-type]


def data_of(number: int, t_ns: int) -> dict[str, bytes]:
    """Return the frames of an instant, which is at `t_ns` of the INS's clock, by message."""
    count = number % 256
    north = number.to_bytes(3, "little", signed=True)
    return {
        "CLOCK": struct.pack("<IBxxx", FIRST_US + t_ns // 1000, count),
        "PLACE": north + north + bytes([count, 0]),
        "DEPTH": struct.pack("<hBx", number, count),
        "TURN": struct.pack("<hhhBx", number, number, number, count),
        "SPEED": struct.pack("<hhhBx", number, number, number, count),
    }


def frames(manner: Manner, instants: int, chance: Random) -> Iterator[Sent]:
    """Yield what arrives, in order; instant n is at n periods."""
    period_ns = round(NS / manner.rate_hz)
    free_ns = 0
    for number in range(instants):
        data = data_of(number, number * period_ns)
        t_ns = number * period_ns + 2 * MS
        held_up = chance.randrange(len(manner.order)) if chance.random() < manner.delayed else -1
        for place, name in enumerate(manner.order):
            t_ns += chance.randrange(period_ns // 2) if place == held_up else 0
            t_ns = free_ns = max(t_ns, free_ns) + manner.frame_ns
            if chance.random() >= manner.lost:
                yield Sent(
                    t_ns + (chance.randrange(manner.jitter_ns) if manner.jitter_ns else 0), IDS[name], data[name]
                )


def number_of(pose: Pose) -> int:
    """Return the instant of a pose; asserts that all that it says is of one, but for its time."""
    number = round(100 * pose.position_ned[0])
    reported = [*(100 * part for part in pose.position_ned), *(1000 * part for part in pose.velocity_body)]
    w, x, y, z = pose.attitude
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    assert [round(part) for part in reported] == [number] * 6
    assert round(1e4 * roll) == number
    return number
