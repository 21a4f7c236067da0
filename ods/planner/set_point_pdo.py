"""The set point on CAN: RPDO 1 of the vehicle, as its EDS file lays it out. Read by the simulated vehicle, too."""

import math
import struct
from pathlib import Path
from typing import Any, NamedTuple

import canopen

from ods.base.errors import OdsError, one_line

MAPPED = [(0x2100, 1), (0x2100, 2), (0x2100, 3)]
"""Heading, speed, down: objects of the EDS, in this order."""


class SetPointPdo(NamedTuple):
    """RPDO 1 of a vehicle."""

    can_id: int
    deadline_s: float
    """Time without a set point after which the vehicle stops: the RPDO's event timer [CiA 301]."""
    layout: struct.Struct
    """Layout of heading, speed and down."""
    factors: tuple[float, ...]
    """Value of one count of each: rad, m/s, m."""

    def encode(self, heading_rad: float, speed_m_s: float, down_m: float) -> bytes:
        """Return the frame's data."""
        values = (heading_rad % (2.0 * math.pi), speed_m_s, down_m)
        return self.layout.pack(*(round(value / unit) for value, unit in zip(values, self.factors, strict=True)))

    def decode(self, data: bytes) -> tuple[float, float, float] | None:
        """Return heading, rad, speed, m/s, and down coordinate, m; None: there are too few bytes."""
        if len(data) < self.layout.size:
            return None
        heading, speed, down = self.layout.unpack_from(data)
        return heading * self.factors[0], speed * self.factors[1], down * self.factors[2]


def pdo_of(eds: Path, node_id: int) -> SetPointPdo:
    """Read it from an EDS file. Raises OdsError."""
    try:
        objects: Any = canopen.import_od(str(eds), node_id)
        mapped = [objects[0x1600][sub].default for sub in range(1, objects[0x1600][0].default + 1)]
        where = [(each >> 16, each >> 8 & 0xFF) for each in mapped]
        can_id, deadline_ms = objects[0x1400][1].default, objects[0x1400][5].default
        variables = [objects[index][sub] for index, sub in where]
        layout = struct.Struct("<" + "".join(each.STRUCT_TYPES[each.data_type].format[-1] for each in variables))
    except Exception as error:  # the library raises what it likes
        raise OdsError(f"{eds}: no RPDO 1 with COB-ID, event timer and mapping: {one_line(error)}") from error
    if where != MAPPED or not deadline_ms:
        raise OdsError(f"{eds}: RPDO 1 must hold 0x2100 sub-indices 1 to 3, and have an event timer")
    return SetPointPdo(can_id, 1e-3 * deadline_ms, layout, tuple(each.factor for each in variables))
