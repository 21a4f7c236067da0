"""Norbit packets made byte by byte as in TN-180196: the codec under test has no part in it."""

import binascii
import struct
from typing import Any

import numpy as np

from ods.base.arrays import AnyArray

HEADER, IMAGE = 24, 192
NUMBERS = {"u1": 0, "i1": 1, "u2": 2, "i2": 3, "u4": 4, "i4": 5, "u8": 6, "i8": 7, "f4": 0x15, "f8": 0x17}


def sealed(body: bytes, kind: int = 2, *, checksum: int | None = None, version: int = 4) -> bytes:
    """A packet of a body, which is all behind the header."""
    crc = binascii.crc32(body) if checksum is None else checksum
    return struct.pack("<IIIIII", 0xDEADBEEF, kind, HEADER + len(body), version, 0, crc) + body


def image(
    samples: AnyArray,
    *,
    number: int = 1,
    time: float = 1.7e9,
    directions: list[float] | None = None,
    sound: float = 1500.0,
    rate: float = 15000.0,
    first: int = 10,
    number_type: int | None = None,
    mode: int = 0,
    elevation: float = 0.0,
    checksum: int | None = None,
    padding: int = 0,
    version: int = 4,
) -> bytes:
    """An image of (samples, beams), one range after another, as it is sent."""
    count, beams = samples.shape
    head = bytearray(IMAGE)
    struct.pack_into("<ff", head, 24, sound, rate)
    struct.pack_into("<II", head, 32, beams, count)
    struct.pack_into("<d", head, 40, time)
    kind = NUMBERS[f"{samples.dtype.kind}{samples.dtype.itemsize}"] if number_type is None else number_type
    struct.pack_into("<I", head, 48, kind)
    struct.pack_into("<i", head, 52, first)
    struct.pack_into("<f", head, 56, 2.0)
    struct.pack_into("<ff", head, 64, 0.1, 2.4)
    struct.pack_into("<fffI", head, 72, 400.0, 80.0, 0.0005, 15)
    struct.pack_into("<f", head, 100, 10.0)
    struct.pack_into("<I", head, 108, number)
    struct.pack_into("<d", head, 112, time + 0.01)
    struct.pack_into("<I", head, 120, beams)
    struct.pack_into("<ifif", head, 124, 5, 0.0, 2000, 40.0)
    struct.pack_into("<ff", head, 144, elevation, float("nan"))
    head[152:154] = bytes([1, mode])
    table = np.linspace(-1.0, 1.0, beams).tolist() if directions is None else directions
    tail = struct.pack(f"<{beams}f", *table) + bytes(padding)
    return sealed(bytes(head[HEADER:]) + samples.tobytes() + tail, checksum=checksum, version=version)


def samples(seed: int, count: int = 6, beams: int = 8, dtype: Any = "<u2") -> AnyArray:
    """Random samples over the type's whole range."""
    kind = np.dtype(dtype)
    rng = np.random.default_rng(seed)
    if kind.kind == "f":
        return rng.random((count, beams)).astype(kind)
    limits = np.iinfo(kind)
    return rng.integers(limits.min, limits.max, (count, beams), kind, endpoint=True)
