"""Sonar 3D-15 packets byte by byte as in Water Linked's documentation: the codec under test has no part in it."""

import binascii
import struct

import numpy as np

from ods.base.arrays import AnyArray


def varint(number: int) -> bytes:
    """A number in 7 bits a byte, the lowest first."""
    out = bytearray()
    while number > 0x7F:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*out, number])


def number(field: int, value: int) -> bytes:
    """A field of an integer."""
    return varint(field << 3) + varint(value)


def real(field: int, value: float) -> bytes:
    """A field of a float."""
    return varint(field << 3 | 5) + struct.pack("<f", value)


def data(field: int, value: bytes) -> bytes:
    """A field of bytes."""
    return varint(field << 3 | 2) + varint(len(value)) + value


def literals(plain: bytes) -> bytes:
    """A Snappy block that copies nothing."""
    out = varint(len(plain))
    for at in range(0, len(plain), 256):
        part = plain[at : at + 256]
        out += bytes([60 << 2, len(part) - 1]) + part
    return out


def sealed(content: bytes, name: bytes = b"RIP2", checksum: int | None = None) -> bytes:
    """A packet of its content."""
    head = name + struct.pack("<I", len(content) + 12) + content
    return head + struct.pack("<I", binascii.crc32(head) if checksum is None else checksum)


def message(kind: str, content: bytes) -> bytes:
    """A message in its wrapping."""
    url = data(1, b"type.googleapis.com/waterlinked.sonar.protocol." + kind.encode())
    return data(1, url + data(2, content))


def pixels(seed: int = 1, width: int = 32, height: int = 8) -> AnyArray:
    """(height, width) numbers, a third of them 0."""
    rng = np.random.default_rng(seed)
    return np.where(rng.random((height, width)) < 0.33, 0, rng.integers(1, 65536, (height, width))).astype(np.uint16)


def range_image(
    image: AnyArray,
    *,
    seq: int = 1,
    time: tuple[int, int] = (1_716_815_835, 840_000_000),
    sound: float = 1491.0,
    reach: float = 15.0,
    opening: tuple[float, float] = (90.0, 40.0),
    scale: float = 0.001,
    size: tuple[int, int] | None = None,
    packed: bytes | None = None,
) -> bytes:
    """The message of a range image of (height, width) numbers, `size`: what it claims of width and height."""
    width, height = size or image.shape[::-1]
    header = data(1, number(1, time[0]) + number(2, time[1])) + number(2, seq)
    content = data(1, header) + real(2, sound) + real(3, reach) + number(4, 1_200_000)
    content += number(5, width) + number(6, height) + real(7, opening[0]) + real(8, opening[1]) + real(9, scale)
    numbers = b"".join(map(varint, image.reshape(-1).tolist())) if packed is None else packed
    return message("RangeImage", content + data(10, numbers))


def packet(image: AnyArray, **reported: object) -> bytes:
    """The packet of a range image; see `range_image`."""
    return sealed(literals(range_image(image, **reported)))  # type: ignore[arg-type]
