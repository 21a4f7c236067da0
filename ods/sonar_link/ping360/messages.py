"""Messages of the ping protocol that a Ping360 sends and takes. Pure codec.

Source: the maker's documentation of the protocol (bluerobotics/ping-protocol, src/definitions/common.json and
ping360.json). All numbers are little endian, without gaps: `BR`, bytes of the payload, message id, source, destination,
payload, and the sum of all bytes before it, modulo 65536.
"""

import struct
from enum import IntEnum
from typing import NamedTuple

START = b"BR"
_HEADER = struct.Struct("<2sHHBB")
_CHECKSUM = struct.Struct("<H")
# Mode, gain, angle, pulse, sample period, frequency; start, stop, steps, delay; samples, bytes of data.
_AUTO = struct.Struct("<BBHHHHHHBBHH")
# The same without what a sector has.
_DEVICE = struct.Struct("<BBHHHHHH")
_AUTO_TRANSMIT = struct.Struct("<BBHHHHHHBB")
_ID = struct.Struct("<H")
_INFORMATION = struct.Struct("<6B")
HEADER_BYTES, CHECKSUM_BYTES = _HEADER.size, _CHECKSUM.size
TURN = 400
"""Steps of the motor, gradians, in a turn."""
TICK_S = 25e-9
"""Unit of the sample period."""
MODE = 1
"""Of a Ping360 in all its messages."""
PING360 = 2
"""As a device type."""
MOST_SAMPLES = 4096
"""The document has 1200; more than these are no beam."""

Buffer = bytes | bytearray | memoryview


class Kind(IntEnum):
    """What a message is, of those that are read or sent here."""

    ACK = 1
    NACK = 2
    ASCII_TEXT = 3
    DEVICE_INFORMATION = 4
    PROTOCOL_VERSION = 5
    GENERAL_REQUEST = 6
    DEVICE_DATA = 2300
    AUTO_DEVICE_DATA = 2301
    TRANSDUCER = 2601
    AUTO_TRANSMIT = 2602
    MOTOR_OFF = 2903


FROM_SONAR = (
    Kind.ACK, Kind.NACK, Kind.ASCII_TEXT, Kind.DEVICE_INFORMATION, Kind.PROTOCOL_VERSION, Kind.DEVICE_DATA,
    Kind.AUTO_DEVICE_DATA,
)  # fmt: skip
"""What a Ping360 sends."""
LEAST_BYTES = {
    Kind.ACK: _ID.size, Kind.NACK: _ID.size, Kind.ASCII_TEXT: 0, Kind.DEVICE_INFORMATION: _INFORMATION.size,
    Kind.PROTOCOL_VERSION: 4, Kind.DEVICE_DATA: _DEVICE.size, Kind.AUTO_DEVICE_DATA: _AUTO.size,
}  # fmt: skip
"""Of the payload."""
MOST_BYTES = _AUTO.size + MOST_SAMPLES


class Header(NamedTuple):
    """What begins a message."""

    kind: int
    payload: int
    """Bytes of it."""

    @property
    def size(self) -> int:
        """Bytes of the whole message."""
        return HEADER_BYTES + self.payload + CHECKSUM_BYTES


class Sweep(NamedTuple):
    """What automatic transmission asks of the head."""

    start: int
    stop: int
    """Gradians, 0 to 399, from one to the other by rising angles, over 0 if need be."""
    steps: int
    """Gradians from beam to beam, 1 to 10."""
    delay_ms: int = 0
    """Between beams, 0 to 100."""


class Beam(NamedTuple):
    """One beam, and how it was taken."""

    gain: int
    """0 low, 1 normal, 2 high."""
    angle: int
    """Of the head, gradians."""
    pulse_us: int
    period: int
    """From sample to sample, `TICK_S` each."""
    frequency_khz: int
    sweep: Sweep | None
    """None: the beam was asked for by itself."""
    samples: bytes


class Transmission(NamedTuple):
    """How beams are to be taken."""

    gain: int
    pulse_us: int
    period: int
    frequency_khz: int
    samples: int


def unpack_header(data: Buffer, at: int = 0) -> Header:
    """Return the header at a place that has HEADER_BYTES; whether START stands there is not looked at."""
    _, payload, kind, _, _ = _HEADER.unpack_from(data, at)
    return Header(kind, payload)


def is_sound(message: memoryview) -> bool:
    """Return whether a whole message has its checksum."""
    body = message[:-CHECKSUM_BYTES]
    return bool(sum(body) & 0xFFFF == _CHECKSUM.unpack_from(message, len(body))[0])


def pack(kind: int, payload: bytes = b"", source: int = 0, destination: int = 0) -> bytes:
    """Return a whole message."""
    body = _HEADER.pack(START, len(payload), kind, source, destination) + payload
    return body + _CHECKSUM.pack(sum(body) & 0xFFFF)


def decode_beam(message: Buffer) -> Beam:
    """Return the beam of a whole message of kind DEVICE_DATA or AUTO_DEVICE_DATA.

    Raises ValueError when its counts do not fit its size.
    """
    header = unpack_header(message)
    if header.kind == Kind.AUTO_DEVICE_DATA:
        mode, gain, angle, pulse, period, khz, *rest = _AUTO.unpack_from(message, HEADER_BYTES)
        start, stop, steps, delay, samples, count = rest
        sweep, begin = Sweep(start, stop, steps, delay), HEADER_BYTES + _AUTO.size
    else:
        mode, gain, angle, pulse, period, khz, samples, count = _DEVICE.unpack_from(message, HEADER_BYTES)
        sweep, begin = None, HEADER_BYTES + _DEVICE.size
    data = bytes(message[begin : begin + count])
    if begin + count != HEADER_BYTES + header.payload or not 0 < len(data) == count == samples:
        raise ValueError(f"{count} samples of {samples} do not fit {header.payload} bytes")
    if angle >= TURN or not period or (sweep and not (sweep.start < TURN and sweep.stop < TURN and sweep.steps)):
        raise ValueError(f"mode {mode}: no head has angle {angle}, sweep {sweep}, sample period {period}")
    return Beam(gain, angle, pulse, period, khz, sweep, data)


def encode_beam(beam: Beam) -> bytes:
    """Return the message of a beam, as a sonar sends it."""
    numbers = MODE, beam.gain, beam.angle, beam.pulse_us, beam.period, beam.frequency_khz
    count = len(beam.samples)
    if beam.sweep is None:
        return pack(Kind.DEVICE_DATA, _DEVICE.pack(*numbers, count, count) + beam.samples, PING360)
    return pack(Kind.AUTO_DEVICE_DATA, _AUTO.pack(*numbers, *beam.sweep, count, count) + beam.samples, PING360)


def auto_transmit(asked: Transmission, sweep: Sweep) -> bytes:
    """Return the request to sweep a sector until the next request."""
    numbers = asked.gain, asked.pulse_us, asked.period, asked.frequency_khz, asked.samples
    return pack(Kind.AUTO_TRANSMIT, _AUTO_TRANSMIT.pack(MODE, *numbers, *sweep))


def decode_auto_transmit(message: Buffer) -> tuple[Transmission, Sweep]:
    """Return what a request to sweep asks for."""
    _, *numbers = _AUTO_TRANSMIT.unpack_from(message, HEADER_BYTES)
    return Transmission(*numbers[:5]), Sweep(*numbers[5:])


def general_request(kind: int) -> bytes:
    """Return the request for a message."""
    return pack(Kind.GENERAL_REQUEST, _ID.pack(kind))


def decode_id(message: Buffer) -> int:
    """Return what an ACK, a NACK or a GENERAL_REQUEST is of."""
    number: int = _ID.unpack_from(message, HEADER_BYTES)[0]
    return number


def decode_text(message: Buffer) -> str:
    """Return the words of a NACK, printable ones only."""
    words = bytes(message[HEADER_BYTES + _ID.size : -CHECKSUM_BYTES]).decode("ascii", "replace")
    return "".join(letter for letter in words if letter.isprintable())[:80]


class Information(NamedTuple):
    """Device information."""

    kind: int
    """Device type."""
    revision: int
    firmware: tuple[int, int, int]


def decode_information(message: Buffer) -> Information:
    """Return what a whole message of kind DEVICE_INFORMATION says."""
    kind, revision, major, minor, patch, _ = _INFORMATION.unpack_from(message, HEADER_BYTES)
    return Information(kind, revision, (major, minor, patch))
