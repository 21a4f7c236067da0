"""Snappy blocks and packed numbers of a packet, unpacked by compiled loops with bounds."""

import numpy as np
from numpy.typing import NDArray

from ods.compiled import native

Buffer = bytes | memoryview
Pixels = NDArray[np.uint16]
LONGEST_LENGTH = 5
"""Bytes that the length of a block has at most: 32 bits."""


def snappy_block(block: Buffer, most_bytes: int) -> bytes:
    """Return what a block of Snappy's raw format holds. Raises ValueError: it is malformed, or holds more."""
    length, begin = 0, 0
    for begin, byte in enumerate(block[:LONGEST_LENGTH], 1):
        length |= (byte & 0x7F) << 7 * (begin - 1)
        if byte < 0x80:
            break
    else:
        raise ValueError("snappy: the length is missing")
    if length > most_bytes:
        raise ValueError(f"snappy: {length} bytes in it, more than {most_bytes}")
    plain = np.empty(length, np.uint8)
    if not native.unpack_snappy(np.frombuffer(block, np.uint8)[begin:], plain):
        raise ValueError("snappy: the block is damaged")
    return plain.tobytes()


def pixels_of(packed: Buffer, columns: int, rows: int) -> Pixels:
    """Return (columns, rows) numbers, sent row by row as varints. Raises ValueError: other ones, or another number of
    them."""
    pixels = np.empty((columns, rows), np.uint16)
    if not native.unpack_pixels(np.frombuffer(packed, np.uint8), pixels):
        raise ValueError(f"pixels: not {rows} x {columns} numbers of 16 bits")
    return pixels
