"""The records that hold a .s7k file together: file header 7200, first in it, and file catalogue 7300, last. Pure codec.

The header's optional data give the catalogue's position; 0 and 0 while there is none, or none any more because the
file was cut off. The catalogue has one entry a record, itself excluded.
Source: 7k Data Format Definition 3.12, sections 7, 10.59 and 10.60.
"""

import struct
from collections.abc import Sequence

from ods import __version__
from ods.sonar_link.s7k import drf
from ods.sonar_link.s7k.records import DEVICE

FILE_HEADER = 7200
FILE_CATALOGUE = 7300

_FILE_HEADER = struct.Struct("<16sHH16sII64s16s64s128s")
_DEVICE = struct.Struct("<IH")
_CATALOGUE_PLACE = struct.Struct("<IQ")
_CATALOGUE = struct.Struct("<IHII")
_ENTRY = struct.Struct("<IQHHH10sI16x")
_VERSION = 1
_NAME_BYTES = 64


def encode_file_header(
    utc_ns: int, name: str, devices: Sequence[drf.DeviceId] = (DEVICE,), catalogue_bytes: int = 0, catalogue_at: int = 0
) -> bytes:
    """Return record 7200, framed. Its length depends on the number of devices only, so it can be rewritten in place."""
    body = _FILE_HEADER.pack(
        bytes(16), _VERSION, 0, bytes(16), _DEVICE.size * len(devices), len(devices),
        text_field(name, _NAME_BYTES), text_field(f"ods {__version__}", 16), b"", b"",
    )  # fmt: skip
    body += b"".join(_DEVICE.pack(*device) for device in devices)
    place = _CATALOGUE_PLACE.pack(catalogue_bytes, catalogue_at)
    return drf.encode_record(FILE_HEADER, body, utc_ns, DEVICE, recorded=True, optional=(FILE_CATALOGUE, place))


def with_catalogue(header_frame: bytes, catalogue_bytes: int, catalogue_at: int) -> bytes:
    """Return a framed record 7200 that says where the catalogue is. Raises ValueError when it has no room for that."""
    header = drf.unpack_record_header(header_frame)
    end = header.optional_offset + _CATALOGUE_PLACE.size
    if header.record_type != FILE_HEADER or not header.optional_offset or end + drf.CHECKSUM_BYTES != len(header_frame):
        raise ValueError("its file header has no room for a catalogue")
    frame = header_frame[: header.optional_offset] + _CATALOGUE_PLACE.pack(catalogue_bytes, catalogue_at)
    return frame + drf.checksum_of(frame).to_bytes(drf.CHECKSUM_BYTES, "little")


def encode_entry(frame: bytes, offset: int) -> bytes:
    """Return the catalogue's entry of the record whose frame begins with `frame` and stands at `offset`."""
    header = drf.unpack_record_header(frame)
    return _ENTRY.pack(
        header.size,
        offset,
        header.record_type & 0xFFFF,
        header.device.number & 0xFFFF,
        header.device.enumerator,
        header.time,
        0,
    )


def encode_catalogue(utc_ns: int | None, entries: bytes) -> bytes:
    """Return record 7300, framed, of entries from `encode_entry`, one behind the other."""
    head = _CATALOGUE.pack(_CATALOGUE.size, _VERSION, len(entries) // _ENTRY.size, 0)
    return drf.encode_record(FILE_CATALOGUE, head + entries, utc_ns, DEVICE, recorded=True)


def text_field(text: str, size: int) -> bytes:
    """Return `text` as null-terminated UTF-8 of `size` bytes, cut off between characters."""
    whole = text.encode()[: size - 1].decode(errors="ignore")
    return whole.encode().ljust(size, b"\0")
