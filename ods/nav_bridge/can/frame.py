"""Frames of a CAN bus, and the identifiers of the CANopen services that are not PDOs (CiA 301)."""

import struct
from typing import NamedTuple

MAX_DATA_BYTES = 8
"""Of a classic CAN frame."""
NMT = 0x000
SYNC = 0x080
TIME = 0x100
EMCY = 0x080
"""Plus node id."""
EMCY_FRAME = struct.Struct("<HB5x")
"""Error code, error register, and what the manufacturer adds."""
SDO_ANSWER = 0x580
"""Plus node id."""
SDO_REQUEST = 0x600
"""Plus node id."""
HEARTBEAT = 0x700
"""Plus node id."""


STANDARD_MASK, EXTENDED_MASK = 0x7FF, 0x1FFFFFFF


class CanId(NamedTuple):
    """Identifier of a frame; 0x185 and extended 0x185 are two."""

    number: int
    extended: bool
    mask: int = EXTENDED_MASK
    """Bits of the identifier that count: of J1939 the parameter group's."""

    def matches(self, number: int, extended: bool) -> bool:
        """Return whether a frame's identifier is this one, or one of its group."""
        return extended == self.extended and (number ^ self.number) & self.mask == 0

    def __str__(self) -> str:
        """As people write it: 0x185, or 0x18FEF000 with all its digits; PGN 61459 of a group [SAE J1939-21]."""
        if self.extended and self.mask != EXTENDED_MASK:
            sender = f" of 0x{self.number & 0xFF:02X}" if self.mask & 0xFF else ""
            return f"PGN {self.number >> 8 & 0x3FFFF}{sender}"
        return f"0x{self.number:08X}" if self.extended else f"0x{self.number:03X}"


class Frame(NamedTuple):
    """A data frame as it came off the bus."""

    can_id: int
    extended: bool
    """29-bit identifier: never CANopen, even when the number is that of a PDO."""
    data: bytes
    t_ns: int
    """Arrival, CLOCK_MONOTONIC."""


class ErrorFrame(NamedTuple):
    """State of the CAN controller, reported by the driver as a frame (Linux, can/error.h)."""

    classes: int
    """Bits, each a kind of error."""
    data: bytes
    """Details of them."""
    t_ns: int
    """Arrival, CLOCK_MONOTONIC."""
