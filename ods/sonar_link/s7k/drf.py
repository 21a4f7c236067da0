"""The Data Record Frame of the RESON 7k Data Format: header, 7KTIME, checksum, record.

Source: Teledyne RESON, 7k Data Format Definition, version 3.12, sections 2.5 and 5. All numbers are little endian.
"""

import math
import struct
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta
from typing import NamedTuple

import numpy as np

from ods.base.clock import NS

SYNC_WORD = b"\xff\xff\x00\x00"
SYNC_AT = 4
"""Where the sync word stands in a frame; the header's offset field counts from here."""
RECORD_VERSION = 5
CHECKSUM_BYTES = 4
CHECKSUM_VALID = 1
RECORDED = 1 << 15

_HEADER = struct.Struct("<HH4sIII10sHIIHHIHHIII")
_TIME = struct.Struct("<HHfBB")
RECORD_HEADER_BYTES = _HEADER.size
UNIX_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
YEARS = range(1970, 2200)
"""Years taken for a real 7KTIME."""
_DAY_NS = 86_400 * NS


class DeviceId(NamedTuple):
    """Which of the devices on a line or in a file."""

    number: int
    """Of its kind: 7000 is "7k sonar source"."""
    enumerator: int = 0
    """Distinguishes two devices of one kind."""


class RecordHeader(NamedTuple):
    """The fields of a frame's header that matter here."""

    version: int
    offset: int
    """From the sync word to the record type header."""
    size: int
    """Of the whole frame, checksum included."""
    optional_offset: int
    """From the frame's start to its optional data; 0 when there are none."""
    time: bytes
    record_type: int
    device: DeviceId
    flags: int


@dataclass(frozen=True, slots=True)
class S7kRecord:
    """One record as it came, without frame, checksum and optional data."""

    record_type: int
    device: DeviceId
    time_ns: int | None
    """7KTIME, UTC ns since 1970; None when the device had no time or an absurd one."""
    body: bytes
    """Record type header and record data."""
    first_ns: int = 0
    """When the frame's first byte was read, as reported to the framer."""
    last_ns: int = 0
    """When the frame's last byte was read."""


def unpack_record_header(buffer: bytes | bytearray) -> RecordHeader:
    """Return the header at the start of `buffer`, which holds at least RECORD_HEADER_BYTES."""
    version, offset, _, size, optional_offset, _, time, _, record_type, device, _, enumerator, _, flags, *_ = (
        _HEADER.unpack_from(buffer)
    )
    return RecordHeader(version, offset, size, optional_offset, time, record_type, DeviceId(device, enumerator), flags)


def encode_record(
    record_type: int,
    body: bytes,
    utc_ns: int | None,
    device: DeviceId,
    recorded: bool = False,
    optional: tuple[int, bytes] | None = None,
) -> bytes:
    """Return the frame of one record, with a valid checksum; `utc_ns` None writes the 7KTIME that says "no time".

    `optional`: identifier and bytes of the optional data behind the body.
    """
    identifier, extra = optional or (0, b"")
    optional_at = RECORD_HEADER_BYTES + len(body) if optional else 0
    size = RECORD_HEADER_BYTES + len(body) + len(extra) + CHECKSUM_BYTES
    header = _HEADER.pack(
        RECORD_VERSION, RECORD_HEADER_BYTES - SYNC_AT, SYNC_WORD, size, optional_at, identifier,
        encode_time(utc_ns), 1, record_type, device.number, 0, device.enumerator,
        0, CHECKSUM_VALID | (RECORDED if recorded else 0), 0, 0, 0, 0,
    )  # fmt: skip
    frame = header + body + extra
    return frame + checksum_of(frame).to_bytes(CHECKSUM_BYTES, "little")


def checksum_of(data: bytes) -> int:
    """Return the sum of all bytes, modulo 2**32."""
    return int(np.frombuffer(data, np.uint8).sum(dtype=np.uint64)) & 0xFFFFFFFF


def decode_time(field: bytes) -> int | None:
    """Return the UTC ns since 1970 of a 10-byte 7KTIME; None when it is all zero, absurd or not a number."""
    year, day, seconds, hours, minutes = _unpack_time(field)
    sane = year in YEARS and 1 <= day <= 366 and hours < 24 and minutes < 60
    if not sane or not math.isfinite(seconds) or not 0.0 <= seconds < 61.0:
        return None
    days = date(year, 1, 1).toordinal() + day - 1 - UNIX_EPOCH.toordinal()
    return days * _DAY_NS + (hours * 3600 + minutes * 60) * NS + round(seconds * NS)


def _unpack_time(field: bytes) -> tuple[int, int, float, int, int]:
    year, day, seconds, hours, minutes = _TIME.unpack(field)
    return year, day, seconds, hours, minutes


def encode_time(utc_ns: int | None) -> bytes:
    """Return the 10-byte 7KTIME of `utc_ns`; its float32 seconds keep 2 us at worst.

    Raises ValueError outside the years 1970 to 2199.
    """
    if utc_ns is None:
        return bytes(_TIME.size)
    whole_s, part_ns = divmod(utc_ns, NS)
    try:
        moment = UNIX_EPOCH + timedelta(seconds=whole_s)
    except OverflowError:
        raise ValueError(f"utc_ns: {utc_ns} is out of range") from None
    if moment.year not in YEARS:
        raise ValueError(f"utc_ns: {utc_ns} lies outside the years {YEARS.start} to {YEARS.stop - 1}")
    seconds = moment.second + part_ns / NS
    return _TIME.pack(moment.year, moment.timetuple().tm_yday, seconds, moment.hour, moment.minute)
