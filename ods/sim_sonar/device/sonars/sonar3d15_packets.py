"""Packets of the Sonar 3D-15 as the sonar itself writes them: protobuf in a Snappy block of literals.

Written from Water Linked's documentation, not from `ods.sonar_link.sonar3d15`: the bench shows a mistake there.
"""

import struct
import zlib
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Bytes, Floats32, Ints

TYPES = "type.googleapis.com/waterlinked.sonar.protocol."
LONGEST_LITERAL = 65536
NS = 1_000_000_000


class ImageSays(NamedTuple):
    """Description of the image in a packet."""

    time_ns: int
    number: int
    sound_speed: float
    range_m: float
    frequency_hz: int
    opening_deg: tuple[float, float]
    """Horizontal and vertical."""
    scale_m: float


def range_image(says: ImageSays, ranges_m: Floats32) -> bytes:
    """Return the packet of (rows, columns) ranges, the lowest row first; 0: no echo."""
    numbers = np.clip(np.rint(ranges_m / says.scale_m), 0, 2**16 - 1).astype(np.int64)
    rows, columns = numbers.shape
    image = _integer(5, columns) + _integer(6, rows) + _opening(7, says)
    image += _real(9, says.scale_m) + _bytes(10, _varints(numbers.ravel()))
    return _packet("RangeImage", _shared_fields(says) + image)


def strength_image(says: ImageSays, strengths: Bytes) -> bytes:
    """Return the packet of (rows, columns) signal strengths."""
    rows, columns = strengths.shape
    image = _integer(6, columns) + _integer(7, rows) + _opening(8, says)
    return _packet("BitmapImageGreyscale8", _shared_fields(says) + image + _bytes(10, strengths.tobytes()))


def _shared_fields(says: ImageSays) -> bytes:
    """Return the fields that all images have."""
    time = _integer(1, says.time_ns // NS) + _integer(2, says.time_ns % NS)
    header = _bytes(1, _bytes(1, time) + _integer(2, says.number % 2**32))
    return header + _real(2, says.sound_speed) + _real(3, says.range_m) + _integer(4, says.frequency_hz)


def _opening(field: int, says: ImageSays) -> bytes:
    return _real(field, says.opening_deg[0]) + _real(field + 1, says.opening_deg[1])


def _packet(kind: str, message: bytes) -> bytes:
    wrapped = _bytes(1, _bytes(1, (TYPES + kind).encode()) + _bytes(2, message))
    content = _snappy(wrapped)
    head = b"RIP2" + struct.pack("<I", len(content) + 12)
    return head + content + struct.pack("<I", zlib.crc32(head + content))


def _snappy(plain: bytes) -> bytes:
    parts = [_varint(len(plain))]
    for at in range(0, len(plain), LONGEST_LITERAL):
        part = plain[at : at + LONGEST_LITERAL]
        parts += [bytes([61 << 2]), struct.pack("<H", len(part) - 1), part]
    return b"".join(parts)


def _varints(numbers: Ints) -> bytes:
    """Return numbers below 2^21, 7 bits a byte."""
    sevens = np.stack([numbers >> shift & 0x7F for shift in (0, 7, 14)], axis=1).astype(np.uint8)
    count = 1 + (numbers > 0x7F).astype(np.intp) + (numbers > 0x3FFF)
    place = np.arange(3)[None, :]
    sevens |= np.where(place < count[:, None] - 1, 0x80, 0).astype(np.uint8)
    return bytes(sevens[place < count[:, None]].tobytes())


def _varint(number: int) -> bytes:
    out = bytearray()
    while number > 0x7F:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*out, number])


def _integer(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _real(field: int, value: float) -> bytes:
    return _varint(field << 3 | 5) + struct.pack("<f", value)


def _bytes(field: int, value: bytes) -> bytes:
    return _varint(field << 3 | 2) + _varint(len(value)) + value
