"""A CANopen source without I/O, and INS frames packed by hand by the mapping of config/ins.eds."""

import struct
from collections import Counter
from pathlib import Path
from typing import Any

from ods.base.clock import NS
from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.can.frame import Frame
from ods.nav_bridge.canopen.source import CanopenSource
from ods.nav_bridge.clocks.utc import Utc, WallClock
from ods.nav_bridge.settings import CanopenSettings, NavSettings
from ods.nav_bridge.source import SourceHost

CONFIG = Path(__file__).parents[2] / "config"
EDS = CONFIG / "ins.eds"
MS = 1_000_000
PERIOD = 10 * MS
DAY_MS = 86_400_000
IDS = (0x185, 0x285, 0x385, 0x485, 0x685, 0x6A5)
UTC_OFFSET = 1_700_000_000 * NS


class Bench:
    """A source, its counters, and frames made by hand."""

    def __init__(self, eds: Path = EDS, **changes: Any) -> None:
        self.counters: Counter[str] = Counter()
        settings = CanopenSettings(ins_eds=eds, node_eds=CONFIG / "ods_node.eds", **changes)
        nav = NavSettings(canopen=settings)
        self.sent: list[tuple[int, bytes]] = []
        self.wall_clock = WallClock(UTC_OFFSET, synchronized=True)
        utc = Utc(lambda: self.wall_clock)
        host = SourceHost(LocalFrame(57.0, 9.9), self._send, self.counters, 0, utc)
        self.source = CanopenSource(nav, settings, host)

    def _send(self, can_id: int, data: bytes) -> None:
        self.sent.append((can_id, data))

    def take(self, can_id: int, data: bytes, t_ns: int, extended: bool = False) -> Pose | None:
        return self.source.take(Frame(can_id, extended, data, t_ns))

    def epoch(self, number: int, only: tuple[int, ...] = (1, 2, 3, 4, 5, 6), **values: int) -> list[Pose]:
        """Feed epoch `number`, sent every 10 ms; return the poses that came of it."""
        found = []
        for place, data in enumerate(pdos(number, **values), 1):
            if place in only:
                found.append(self.take(IDS[place - 1], data, number * PERIOD + place * 250_000))
        return [pose for pose in found if pose is not None]


def pdos(number: int, **values: int) -> list[bytes]:
    """Return the six PDOs of one epoch as raw counts."""
    v = {
        "status": 15, "ms": 43_200_000 + number * 10, "days": 15_000, "n": 12_345, "e": -6_789, "d": 4_200,
        "sequence": number % 256, "roll": -523, "pitch": 1_047, "yaw": -31_000, "u": 1_500, "v": -20, "w": 35,
    } | values  # fmt: skip
    sequence = v["sequence"]
    return [
        struct.pack("<BBIH", sequence, v["status"], v["ms"] % DAY_MS if v["ms"] < DAY_MS else v["ms"], v["days"]),
        struct.pack("<ii", v["n"], v["e"]),
        struct.pack("<iB", v["d"], sequence),
        struct.pack("<hhhB", v["roll"], v["pitch"], v["yaw"], sequence),
        struct.pack("<hhhB", v["u"], v["v"], v["w"], sequence),
        struct.pack("<HHBHB", 250, 40, 3, 123, sequence),
    ]


def lost(counters: Counter[str]) -> dict[str, int]:
    """Return the counters that tell of trouble."""
    return {name: count for name, count in counters.items() if count and name not in ("sync", "time")}
