"""Messages of the Blueprint Oculus: header, fire message, simple ping result, status. Pure codec.

Sources: the structures that the maker published with its sample viewer, as liboculus (Applied Physics Laboratory,
University of Washington), oculus_driver (ENSTA Bretagne) and sonar_oculus_m750d (Tidewise) have them; they agree. All
numbers are little endian and packed without gaps. How the three differ: docs/sonars/oculus.md.
"""

import math
import struct
from collections.abc import Sequence
from enum import IntEnum, IntFlag
from ipaddress import IPv4Address
from mmap import mmap
from typing import NamedTuple

from ods.sonar_link.ping_builder import MAX_BEAMS, MAX_SAMPLES

STATUS_PORT = 52102
"""UDP, broadcast by the sonar."""
CHECK_WORD = b"SO"
"""0x4f53, first in every message."""
SECOND_VERSION = 2
"""Of fire message and simple ping result; every other number means the first."""
GAIN_BYTES = 4
"""Of the gain before each line, where the sonar sends it."""

Buffer = bytes | bytearray | memoryview | mmap


class MessageKind(IntEnum):
    """Message identifiers."""

    FIRE = 0x15
    FULL_PING = 0x22
    """For the maker's own software; its layout is not known."""
    PING = 0x23
    """The simple ping result."""
    USER_CONFIG = 0x55
    LOG = 0x80
    DUMMY = 0xFF
    """Sent instead of pings by a sonar in standby."""


class Flags(IntFlag):
    """Bits of `Fire.flags`; bits 5 and 7 are not known."""

    RANGE_IN_METRES = 1 << 0
    SIXTEEN_BIT = 1 << 1
    SENDS_GAIN = 1 << 2
    SIMPLE_RESULT = 1 << 3
    GAIN_ASSIST = 1 << 4
    BEAMS_512 = 1 << 6


THIRTY_TWO_BIT = 1 << 9
"""Bit of `Fire.extended_flags`."""

_HEADER = struct.Struct("<2sHHHHIH")
_FIRE = struct.Struct("<5B4d")
_FIRE_2_END = struct.Struct("<I32x")
# Number; frequency; sound speed; sample size, line spacing, lines, beams; offset and size of the image, size of all.
# Left out: status, temperature, pressure, start time (of no known unit).
_RESULT_1 = struct.Struct("<I4xd16xd4xBdHHIII")
# The same with the start time, s. Left out: status, temperature, pressure, heading, pitch, roll.
_RESULT_2 = struct.Struct("<I4xd40xddBdHH16xIII")
# Device, its type and part number, status, versions; own address, its mask, the client's address; MAC address;
# temperatures, pressure.
_STATUS = struct.Struct("<IHHI24x4s4x4s6x8dd")
HEADER_BYTES = _HEADER.size
STATUS_BYTES = HEADER_BYTES + _STATUS.size


class Header(NamedTuple):
    """What begins every message."""

    kind: int
    version: int
    source: int
    """Device number of who sent it."""
    size: int
    """Bytes of the whole message."""


class Fire(NamedTuple):
    """A sonar's requested settings, and in each ping result the used ones."""

    mode: int
    """1: low frequency; 2: high."""
    ping_rate: int
    """A number of PING_RATES; sonars do not repeat it truly."""
    network_speed: int
    """Highest rate, Mbit/s; 0 and 255: that of the link."""
    gamma: int
    """Samples are amplitudes to the power gamma / 255; 0 means 255."""
    flags: int
    range_m: float
    """In percent of the longest without RANGE_IN_METRES."""
    gain_percent: float
    sound_speed: float
    """m/s; 0: computed by the sonar, from its temperature sensor and the salinity."""
    salinity_ppt: float
    extended_flags: int = 0
    """Of the second version only."""


PING_RATES: dict[int, int] = {10: 0, 15: 1, 40: 2, 5: 3, 2: 4}
"""`Fire.ping_rate` by the highest rate in pings a second."""


class SimpleResult(NamedTuple):
    """Description of the image in a simple ping result."""

    fire: Fire
    ping_number: int
    frequency_hz: float
    sound_speed: float
    start_s: float | None
    """Transmission by the sonar's clock, s since it was switched on; None when not reported."""
    sample_bytes: int
    dr_m: float
    lines: int
    beams: int
    bearings_at: int
    """Where the bearing table begins, counted from the message's start like all places."""
    image_at: int
    image_bytes: int
    message_bytes: int

    @property
    def line_bytes(self) -> int:
        """Bytes of one line, with its gain where there is one; 0 when the image's size fits no line.

        The flag that says whether there are gains is not to be trusted in second-version results, but the size is.
        """
        plain = self.beams * self.sample_bytes
        fitting = (size for size in (plain, plain + GAIN_BYTES) if self.lines * size == self.image_bytes)
        return next(fitting, 0)


class SonarStatus(NamedTuple):
    """A sonar's status broadcast."""

    device: int
    part_number: int
    state: int
    """Bits, see oculus/status.py."""
    address: IPv4Address
    client: IPv4Address
    """Address of the connected client; 0.0.0.0: none."""
    temperatures_c: Sequence[float]
    pressure_bar: float


def unpack_header(data: Buffer, at: int = 0) -> Header:
    """Return the header at a place that has HEADER_BYTES; whether CHECK_WORD stands there is not looked at."""
    _, source, _, kind, version, payload, _ = _HEADER.unpack_from(data, at)
    return Header(kind, version, source, HEADER_BYTES + payload)


def encode_fire(fire: Fire, version: int) -> bytes:
    """Return a fire message of version 1 or 2, to any sonar."""
    body = _FIRE.pack(*fire[:9])
    if version == SECOND_VERSION:
        body += _FIRE_2_END.pack(fire.extended_flags)
    return _HEADER.pack(CHECK_WORD, 0, 0, MessageKind.FIRE, version, len(body), 0) + body


def result_bytes(version: int) -> int:
    """Return where the bearing table of a simple ping result begins: all before it is of one length."""
    if version == SECOND_VERSION:
        return HEADER_BYTES + _FIRE.size + _FIRE_2_END.size + _RESULT_2.size
    return HEADER_BYTES + _FIRE.size + _RESULT_1.size


def decode_ping_result(data: Buffer, at: int = 0) -> SimpleResult:
    """Return what a simple ping result says; its first `result_bytes` must be there. What it says is not checked."""
    version = unpack_header(data, at).version
    fire = Fire(*_FIRE.unpack_from(data, at + HEADER_BYTES))
    start_s: float | None = None
    if version == SECOND_VERSION:
        (extended,) = _FIRE_2_END.unpack_from(data, at + HEADER_BYTES + _FIRE.size)
        fire = fire._replace(extended_flags=extended)
        fields = _RESULT_2.unpack_from(data, at + result_bytes(version) - _RESULT_2.size)
        number, frequency, speed, start_s, sample_size, *rest = fields
    else:
        fields = _RESULT_1.unpack_from(data, at + result_bytes(version) - _RESULT_1.size)
        number, frequency, speed, sample_size, *rest = fields
    dr_m, lines, beams, image_at, image_bytes, message_bytes = rest
    return SimpleResult(
        fire, number, frequency, speed, start_s, sample_size + 1,
        dr_m, lines, beams, result_bytes(version), image_at, image_bytes, message_bytes,
    )  # fmt: skip


def fits(result: SimpleResult, size: int) -> bool:
    """Return whether a simple ping result fits a message of this number of bytes."""
    return (
        1 <= result.beams <= MAX_BEAMS
        and 1 <= result.lines <= MAX_SAMPLES
        and result.line_bytes > 0
        and result.bearings_at + 2 * result.beams <= result.image_at
        and result.image_at + result.image_bytes <= size
        and all(map(math.isfinite, (result.dr_m, result.sound_speed, result.frequency_hz)))
    )


def decode_status(datagram: bytes) -> SonarStatus:
    """Decode a status. Raises ValueError when it is malformed."""
    if len(datagram) != STATUS_BYTES or not datagram.startswith(CHECK_WORD):
        raise ValueError("not a status message")
    device, _, part, state, address, client, *temperatures, pressure = _STATUS.unpack_from(datagram, HEADER_BYTES)
    return SonarStatus(device, part, state, IPv4Address(address), IPv4Address(client), temperatures, pressure)
