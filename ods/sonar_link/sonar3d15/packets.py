"""Packets of the Sonar 3D-15, the Range Image Protocol: one in a UDP datagram. Pure codec.

Source: Water Linked's documentation of the integration API (waterlinked/docs, docs/sonar-3d/sonar-3d-15-api.md) and
the definitions that its client `wlsonar` carries. All is little endian: "RIP2", the size of the whole packet, a
protobuf message packed by Snappy ("RIP1": not packed), and CRC-32 of all before it.
`RIP2.proto` there has the fields.
"""

import struct
import zlib
from mmap import mmap
from typing import NamedTuple

from ods.sonar_link.sonar3d15.protobuf import Message
from ods.sonar_link.sonar3d15.unpack import snappy_block

SYNC = b"RIP"
PLAIN, PACKED = b"RIP1", b"RIP2"
GROUP, PORT = "224.0.0.96", 4747
"""Where the sonar sends to, unless it is set to one address only."""
HEAD_BYTES, CHECKSUM_BYTES = 8, 4
MAX_PACKET_BYTES = 65_507
"""What a UDP datagram holds."""
MAX_MESSAGE_BYTES = 4 * MAX_PACKET_BYTES
"""Of a packet that was packed: a range image of the most numbers has a fifth of it."""
RANGE_IMAGE, BITMAP, IMU = "RangeImage", "BitmapImageGreyscale8", "ImuBatch"
"""Kinds of messages: the last part of a type's URL."""
_SIZE = struct.Struct("<I")

Buffer = bytes | memoryview | mmap


class Packet(NamedTuple):
    """Contents of a packet."""

    kind: str
    """RANGE_IMAGE, BITMAP, IMU, or what the sonar calls it."""
    message: memoryview


class RangeImage(NamedTuple):
    """The numbers of a range image, as they were sent: nothing is checked."""

    time_ns: int
    """UTC by the sonar's clock, ns; 0: not reported."""
    number: int
    sound_speed: float
    """m/s."""
    range_m: float
    """The longest that it is set to."""
    frequency: int
    """Said to be in Hz; recordings have 5."""
    width: int
    height: int
    opening_deg: float
    """Horizontal opening."""
    vertical_deg: float
    """Vertical opening."""
    scale_m: float
    """Of a pixel's number."""
    packed: memoryview
    """Pixels, row after row, the lowest first."""


def fault_of(data: Buffer, at: int = 0, max_bytes: int = MAX_PACKET_BYTES) -> str | None:
    """Return why the bytes from `at` on begin no packet, by the counter's name; '' when they do; None: there are too
    few."""
    head = data[at : at + HEAD_BYTES]
    if not (head[:4] in (PLAIN, PACKED) or any(name.startswith(head[:4]) for name in (PLAIN, PACKED))):
        return "unknown_message"
    if len(head) < HEAD_BYTES:
        return None
    size = size_of(data, at)
    if size > max_bytes:
        return "overlong_record"
    return "short_record" if size < HEAD_BYTES + CHECKSUM_BYTES else ""


def size_of(data: Buffer, at: int = 0) -> int:
    """Return the bytes of the packet whose head is there."""
    return int(_SIZE.unpack_from(data, at + 4)[0])


def is_sound(data: bytes | memoryview) -> bool:
    """Return whether the checksum of a whole packet is right."""
    view = memoryview(data)
    return zlib.crc32(view[:-CHECKSUM_BYTES]) == int(_SIZE.unpack(view[-CHECKSUM_BYTES:])[0])


def unpack(data: bytes | memoryview) -> Packet:
    """Return what a whole packet holds. Raises ValueError."""
    view = memoryview(data)
    content: bytes | memoryview = view[HEAD_BYTES:-CHECKSUM_BYTES]
    if view[:4] == PACKED:
        content = snappy_block(content, MAX_MESSAGE_BYTES)
    wrapped = Message(Message(content).data(1))
    name = bytes(wrapped.data(1)[-100:]).decode("utf-8", "replace")
    return Packet(name.rpartition(".")[2], wrapped.data(2))


def decode_range_image(message: memoryview) -> RangeImage:
    """Return the numbers of a range image. Raises ValueError."""
    fields = Message(message)
    header = Message(fields.data(1))
    time = Message(header.data(1))
    return RangeImage(
        time_ns=time.integer(1) * 1_000_000_000 + time.integer(2),
        number=header.integer(2),
        sound_speed=fields.real(2),
        range_m=fields.real(3),
        frequency=fields.integer(4),
        width=fields.integer(5),
        height=fields.integer(6),
        opening_deg=fields.real(7),
        vertical_deg=fields.real(8),
        scale_m=fields.real(9),
        packed=fields.data(10),
    )
