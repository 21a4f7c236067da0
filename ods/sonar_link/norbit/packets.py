"""Packets of the Norbit WBMS: the header of all kinds, and the image of beams ("water column data"). Pure codec.

Source: the maker's TN-180196, WBMS DFD External, rev. 1 and 2, section 8.2, which two public drivers carry and read
(norbit of the University of Rhode Island, norbit_wbms_driver of KTH). All numbers are little endian, without gaps.
docs/sonars/norbit.md names them, and what is open.
"""

import math
import struct
import zlib
from enum import IntEnum
from mmap import mmap
from typing import NamedTuple

import numpy as np

from ods.sonar_link.ping_builder import MAX_BEAMS, MAX_SAMPLES

IMAGE_PORT, COMMAND_PORT = 2211, 2209
"""TCP. The bathymetry has 2210, snippets and side scan 2212."""
PREAMBLE = (0xDEADBEEF).to_bytes(4, "little")
FORWARD = 0
"""`ImageHead.mode` of a forward-looking sonar; the others are for sea-beds."""
LEAST_HZ = 5000.0
"""The document has kHz in images and Hz in bathymetry; a frequency above it is in Hz."""

Buffer = bytes | bytearray | memoryview | mmap


class PacketKind(IntEnum):
    """Contents of a packet."""

    BATHYMETRY = 1
    IMAGE = 2
    SNIPPETS = 4
    SIDE_SCAN = 5


SAMPLE_TYPES: dict[int, np.dtype[np.generic]] = {
    number: np.dtype(name)
    for number, name in {
        0: "u1", 1: "i1", 2: "<u2", 3: "<i2", 4: "<u4", 5: "<i4", 6: "<u8", 7: "<i8", 0x15: "<f4", 0x17: "<f8",
    }.items()
}  # fmt: skip
"""By the numbers of the packets."""

_HEADER = struct.Struct("<4s3I4xI")
# Sound speed, sample rate, beams, samples; time; sample type, first sample, gain. Swath's direction and opening,
# carrier, bandwidth, pulse; amplitude. Ping rate. Ping number. Gain line: sample and dB, twice. Elevation; spacing of
# beams, mode. Left out: time on the network, beams before decimation, voltage, tilt of the gate.
_IMAGE = struct.Struct("<2f2IdIif4x5fI12xf4xI12xifif4xf4x2B38x")
HEADER_BYTES = _HEADER.size
IMAGE_AT = HEADER_BYTES + _IMAGE.size
"""Where the samples begin."""
DIRECTION_BYTES = 4


class Header(NamedTuple):
    """What begins every packet."""

    kind: int
    size: int
    """Bytes of the whole packet."""
    version: int
    checksum: int
    """CRC-32 of all behind the header; 0: not reported, as in snippets."""


class ImageHead(NamedTuple):
    """Description of the image in a packet."""

    sound_speed: float
    sample_rate_hz: float
    beams: int
    samples: int
    time_s: float
    """Transmission by the sonar's clock: Unix time, or time since it was switched on."""
    sample_type: int
    """A number of SAMPLE_TYPES."""
    first_sample: int
    """Number of the first sample; that of transmission is 0."""
    gain: float
    """Of the digital stages; the document reports no unit."""
    direction_rad: float
    opening_rad: float
    frequency: float
    """kHz, see `frequency_hz`."""
    bandwidth_khz: float
    pulse_s: float
    amplitude: int
    ping_rate_hz: float
    ping_number: int
    gain_from_sample: int
    """The analogue gain is that of `gain_from_db` up to here, then runs evenly, in dB,"""
    gain_from_db: float
    gain_to_sample: int
    """to that of `gain_to_db` here."""
    gain_to_db: float
    elevation_rad: float
    """Of the transmission, up positive in a sonar mounted with its projector upwards."""
    beam_spacing: int
    mode: int

    @property
    def directions_at(self) -> int:
        """Where the beams' directions begin; the sample type must be known."""
        return IMAGE_AT + self.beams * self.samples * SAMPLE_TYPES[self.sample_type].itemsize

    @property
    def least_bytes(self) -> int:
        """What the packet must have at least; some firmware fills all of them up to one size."""
        if self.sample_type not in SAMPLE_TYPES:
            return IMAGE_AT
        return self.directions_at + DIRECTION_BYTES * self.beams

    @property
    def frequency_hz(self) -> float:
        """Carrier frequency, 0 when the packet's is invalid."""
        if not 0.0 < self.frequency < 1e7:  # false for NaN too
            return 0.0
        return self.frequency if self.frequency > LEAST_HZ else 1e3 * self.frequency


def unpack_header(data: Buffer, at: int = 0) -> Header:
    """Return the header at a place that has HEADER_BYTES; whether PREAMBLE stands there is not looked at."""
    _, kind, size, version, checksum = _HEADER.unpack_from(data, at)
    return Header(kind, size, version, checksum)


def decode_image_head(data: Buffer, at: int = 0) -> ImageHead:
    """Return what an image says; its first IMAGE_AT bytes must be there. What it says is not checked."""
    return ImageHead(*_IMAGE.unpack_from(data, at + HEADER_BYTES))


def fits(head: ImageHead, size: int) -> bool:
    """Return whether an image fits a packet of this number of bytes."""
    return (
        1 <= head.beams <= MAX_BEAMS
        and 1 <= head.samples <= MAX_SAMPLES
        and head.least_bytes <= size
        and math.isfinite(head.sound_speed)
        and math.isfinite(head.sample_rate_hz)
    )


def is_sound(data: memoryview, header: Header) -> bool:
    """Return whether a whole packet has its checksum, or none is stated."""
    return header.checksum in (0, zlib.crc32(data[HEADER_BYTES : header.size]))
