"""Oculus messages made byte by byte at the places of the maker's structures, without the codec under test."""

import struct
from typing import Any

import numpy as np

from ods.base.arrays import AnyArray

HEADER, RESULT_1, RESULT_2, STATUS = 16, 122, 202, 142


def header(kind: int, size: int, version: int = 0, source: int = 7892) -> bytearray:
    """A message of `size` bytes, all 0 behind its header."""
    data = bytearray(size)
    data[0:2] = b"SO"
    struct.pack_into("<H", data, 2, source)
    struct.pack_into("<H", data, 6, kind)
    struct.pack_into("<H", data, 8, version)
    struct.pack_into("<I", data, 10, size - 16)
    return data


def put_fire(data: bytearray, **fields: float) -> None:
    """Fill the fire message's fields, from byte 16 on."""
    values = {"mode": 1, "rate": 0, "speed": 255, "gamma": 255, "flags": 0x49, "range": 40.0, "gain": 50.0} | fields
    places = {"mode": 16, "rate": 17, "speed": 18, "gamma": 19, "flags": 20}
    for name, place in places.items():
        data[place] = int(values[name])
    for name, place in {"range": 21, "gain": 29, "sound": 37, "salinity": 45}.items():
        struct.pack_into("<d", data, place, values.get(name, 0.0))


def ping(
    image: AnyArray,
    version: int = 2,
    *,
    number: int = 1,
    bearings: list[int] | None = None,
    start: float = 100.0,
    gains: bool = False,
    dr: float = 0.05,
    sound: float = 1500.0,
    **fire: float,
) -> bytes:
    """A simple ping result of (lines, beams) samples: two bytes apart for the version, else the same numbers."""
    lines, beams = image.shape
    table = [(beam - beams // 2) * 25 for beam in range(beams)] if bearings is None else bearings
    fixed = RESULT_2 if version == 2 else RESULT_1
    rows = [(struct.pack("<I", 4 + line) if gains else b"") + image[line].tobytes() for line in range(lines)]
    body = b"".join(rows)
    at = fixed + 2 * beams
    data = header(0x23, at + len(body), version)
    put_fire(data, **fire)
    first = 89 if version == 2 else 53
    struct.pack_into("<I", data, first, number)
    struct.pack_into("<d", data, first + 8, 750e3)
    if version == 2:
        struct.pack_into("<d", data, 145, sound)
        struct.pack_into("<d", data, 153, start)
        rest, tail = 161, 190
    else:
        struct.pack_into("<d", data, 85, sound)
        struct.pack_into("<I", data, 93, 3103899264)
        rest, tail = 97, 110
    data[rest] = image.dtype.itemsize - 1
    struct.pack_into("<d", data, rest + 1, dr)
    struct.pack_into("<HH", data, rest + 9, lines, beams)
    struct.pack_into("<III", data, tail, at, len(body), len(data))
    struct.pack_into(f"<{beams}h", data, fixed, *table)
    data[at:] = body
    return bytes(data)


def status(address: str = "192.168.2.3", client: str = "0.0.0.0", part: int = 1032, state: int = 3) -> bytes:
    """A status broadcast."""
    data = header(0x00, STATUS)
    struct.pack_into("<I", data, 16, 7892)
    struct.pack_into("<HHI", data, 20, 1, part, state)
    data[52:56] = bytes(map(int, address.split(".")))
    data[56:60] = bytes([255, 255, 255, 0])
    data[60:64] = bytes(map(int, client.split(".")))
    struct.pack_into("<8d", data, 70, 20.0, 21.0, 22.0, 23.0, 24.0, 25.0, 31.5, 2.6e-76)
    struct.pack_into("<d", data, 134, 1.25)
    return bytes(data)


def image(seed: int, lines: int = 5, beams: int = 8, dtype: Any = "u1") -> AnyArray:
    """Random samples over the type's whole range."""
    kind = np.dtype(dtype)
    return np.random.default_rng(seed).integers(0, np.iinfo(kind).max, (lines, beams), kind, endpoint=True)
