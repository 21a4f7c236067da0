"""The s7k record of an obstacle, 3001 contact output. Pure codec.

Source: 7k Data Format Definition 3.12, section 10.22. The document leaves the lengths of the three texts open; they are
128 bytes each in MB-System (mbsys_reson7k3), the only public reader that has this record.
"""

import struct
from dataclasses import dataclass
from enum import IntEnum

from ods.sonar_link.files.s7k.catalogue import text_field
from ods.sonar_link.s7k import drf
from ods.sonar_link.s7k.records import DEVICE

CONTACT_OUTPUT = 3001
TEXT_BYTES = 128
OPERATOR = "ods"

_CONTACT = struct.Struct("<II10s128sIffIddfff128s128s")
_POSITION_VALID = 1 << 0
_LENGTH_VALID = 1 << 2
_WIDTH_VALID = 1 << 3


class Change(IntEnum):
    """What became of a contact."""

    CREATED = 0
    MODIFIED = 1
    DELETED = 2


@dataclass(frozen=True)
class Contact:
    """Record 3001 of one obstacle."""

    target_id: int
    ping_number: int
    seen_utc_ns: int
    change: Change
    range_m: float
    bearing_rad: float
    """From straight ahead, starboard positive."""
    latitude_rad: float
    longitude_rad: float
    diameter_m: float
    """Length and width."""
    classification: str
    description: str


def encode_contact(contact: Contact, utc_ns: int) -> bytes:
    """Return record 3001, framed. Raises ValueError for a time that 7KTIME cannot represent."""
    body = _CONTACT.pack(
        contact.target_id % 2**32, contact.ping_number % 2**32, drf.encode_time(contact.seen_utc_ns),
        text_field(OPERATOR, TEXT_BYTES), contact.change, contact.range_m, contact.bearing_rad,
        _POSITION_VALID | _LENGTH_VALID | _WIDTH_VALID, contact.latitude_rad, contact.longitude_rad,
        0.0, contact.diameter_m, contact.diameter_m,
        text_field(contact.classification, TEXT_BYTES), text_field(contact.description, TEXT_BYTES),
    )  # fmt: skip
    return drf.encode_record(CONTACT_OUTPUT, body, utc_ns, DEVICE, recorded=True)
