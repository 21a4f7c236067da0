"""The s7k records of a forward-looking sonar: settings 7000, beam geometry 7004, samples 7018 and 7042. Pure codec.

Used by the sonar link, by .s7k files and by the simulator's far end. What the wire says is not trusted: a record that
cannot be used is a `Loss`, and nothing is raised.
Source: 7k Data Format Definition 3.12, sections 10.23, 10.27, 10.36, 10.47.
"""

import struct
from dataclasses import dataclass

import numpy as np

from ods.messages import Ping
from ods.sonar_link.ping_builder import MAX_BEAMS, SOUND_SPEEDS, BeamTable, make_beam_table
from ods.sonar_link.s7k import water_column
from ods.sonar_link.s7k.drf import DeviceId, S7kRecord, encode_record
from ods.sonar_link.s7k.loss import Loss, RecordError
from ods.sonar_link.s7k.water_column import WaterColumn
from ods.sonar_link.setting_requests import Controls

SONAR_SETTINGS = 7000
BEAM_GEOMETRY = 7004
BEAMFORMED_DATA = 7018
COMPRESSED_WATER_COLUMN = 7042

DEVICE = DeviceId(7000)
"""Device identifier of our own records: "7k sonar source"; the SeaBat 6012 is older than the format and has none."""
SAMPLE_RATES = (1.0, 1e8)
"""Hz."""
SAMPLE_GRID_TOLERANCE = 1e-3
"""Share of a sample that `range0_m` may lie off the sampling grid."""

_SETTINGS = struct.Struct(
    "<QIH"  # sonar, ping number, multi-ping sequence
    "ffff"  # frequency, sample rate, receiver bandwidth, pulse width
    "IIfHH"  # pulse: type, envelope, its parameter, mode, reserved
    "fffffI"  # ping rate, ping period, range, power, gain, control flags
    "IfffffIfI"  # projector: identifier, steering (2), width (2), focus, window, its parameter; transmit flags
    "IIfIf"  # receiver: identifier, window, its parameter, flags, beam width
    "fffffffH"  # bottom detection filter (4), absorption, sound speed, spreading, reserved
)
_RANGE_FIELD = 14
"""Of _SETTINGS; power and gain follow."""
_GEOMETRY = struct.Struct("<QI")


@dataclass(frozen=True)
class SettingsRecord:
    """The parts of record 7000 used here."""

    ping_number: int
    multi_ping: int
    """Place in a multi-ping sequence, 0 when not in one."""
    frequency_hz: float
    sample_rate_hz: float
    sound_speed: float
    controls: Controls


Content = SettingsRecord | BeamTable | WaterColumn


def decode(record: S7kRecord) -> Content | Loss | None:
    """Return a decoded record, or the reason why it cannot be used; None for an unused type."""
    try:
        return _decode(record)
    except RecordError as error:
        return error.loss


def _decode(record: S7kRecord) -> Content | None:
    if record.record_type == SONAR_SETTINGS:
        return _decode_settings(record.body)
    if record.record_type == BEAM_GEOMETRY:
        return _decode_geometry(record.body)
    if record.record_type == BEAMFORMED_DATA:
        return water_column.decode_7018(record.body)
    if record.record_type == COMPRESSED_WATER_COLUMN:
        return water_column.decode_7042(record.body)
    return None


def encode_ping(ping: Ping, device: DeviceId = DEVICE, recorded: bool = False) -> bytes:
    """Return the records of one ping, framed, one after another. Raises ValueError: see `ping_records`."""
    return b"".join(ping_records(ping, device, recorded))


def ping_records(
    ping: Ping, device: DeviceId = DEVICE, recorded: bool = False, controls: Controls | None = None
) -> list[bytes]:
    """Return the records of one ping, framed: 7000, 7004, and its samples, stamped with `ping.utc_ns`.

    `controls` is what record 7000 says of range, power and gain; by default the ping's own range and 0 dB.

    8-bit samples of scale log8, and all that do not start at range 0, go into record 7042; linear uint16 samples that
    do into 7018. Raises ValueError for what the format cannot carry: other scales, a first range that is no multiple of
    the sample spacing.
    """
    if (ping.scale, ping.dtype) not in (("log8", "u1"), ("linear", "u2"), ("linear", "f4")):
        raise ValueError(f"ping {ping.ping_number}: s7k has no record for {ping.dtype} samples of scale {ping.scale}")
    first_sample = first_sample_of(ping.range0_m, ping.dr_m)
    rate = 0.5 * ping.sound_speed / ping.dr_m
    if ping.dtype == "u2" and first_sample == 0:
        samples = BEAMFORMED_DATA, water_column.encode_7018(ping)
    else:
        samples = COMPRESSED_WATER_COLUMN, water_column.encode_7042(ping, first_sample, rate)
    shown = controls or Controls(ping.range0_m + ping.samples * ping.dr_m, 0.0, 0.0)
    settings = SONAR_SETTINGS, _encode_settings(ping, rate, shown)
    return [
        encode_record(record_type, body, ping.utc_ns, device, recorded)
        for record_type, body in (settings, (BEAM_GEOMETRY, _encode_geometry(ping)), samples)
    ]


def first_sample_of(range0_m: float, dr_m: float) -> int:
    """Return the time of the first sample after transmission, in whole samples, as 7042 has it. Raises ValueError."""
    first = round(range0_m / dr_m)
    if abs(range0_m / dr_m - first) > SAMPLE_GRID_TOLERANCE:
        raise ValueError(f"range0_m: {range0_m:g} is not a multiple of dr_m ({dr_m:g}), as s7k records require")
    return first


def _decode_settings(body: bytes) -> SettingsRecord:
    if len(body) < _SETTINGS.size:
        raise RecordError(Loss.BAD_SETTINGS)
    fields = _SETTINGS.unpack_from(body)
    _, ping_number, multi_ping, frequency, rate, *_ = fields
    sound_speed = fields[-3]
    # written so that NaN is refused
    if not (SAMPLE_RATES[0] <= rate <= SAMPLE_RATES[1] and SOUND_SPEEDS[0] <= sound_speed <= SOUND_SPEEDS[1]):
        raise RecordError(Loss.BAD_SETTINGS)
    known = 0.0 < frequency < 1e9
    controls = Controls(*fields[_RANGE_FIELD : _RANGE_FIELD + 3])
    return SettingsRecord(ping_number, multi_ping, frequency if known else 0.0, rate, sound_speed, controls)


def _encode_settings(ping: Ping, sample_rate_hz: float, controls: Controls) -> bytes:
    width = ping.beam_width_rad[ping.beams // 2] if ping.beam_width_rad else 0.0
    return _SETTINGS.pack(
        0, ping.ping_number % 2**32, 0,
        ping.frequency_hz, sample_rate_hz, 0.0, 0.0,
        0, 0, 0.0, 1, 0,
        0.0, 0.0, controls.range_m, controls.power_db, controls.gain_db, 0,
        0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 0.0, 0,
        0, 0, 0.0, 0, width,
        0.0, 0.0, 0.0, 0.0, 0.0, ping.sound_speed, 0.0, 0,
    )  # fmt: skip


def _decode_geometry(body: bytes) -> BeamTable:
    if len(body) < _GEOMETRY.size:
        raise RecordError(Loss.BAD_BEAM_TABLE)
    _, beams = _GEOMETRY.unpack_from(body)
    if not 1 <= beams <= MAX_BEAMS or len(body) < _GEOMETRY.size + 4 * beams * 4:
        raise RecordError(Loss.BAD_BEAM_TABLE)
    rows = np.frombuffer(body, "<f4", 4 * beams, _GEOMETRY.size).reshape(4, beams)
    with np.errstate(invalid="ignore"):  # a signalling NaN, which `make_beam_table` refuses like any other
        vertical, horizontal, _, horizontal_width = rows.astype(np.float64)
    try:
        return make_beam_table(horizontal, vertical, horizontal_width)
    except ValueError:
        raise RecordError(Loss.BAD_BEAM_TABLE) from None


def _encode_geometry(ping: Ping) -> bytes:
    none = [0.0] * ping.beams
    rows = [ping.elevation_rad or none, ping.bearing_rad, none, ping.beam_width_rad or none]
    return _GEOMETRY.pack(0, ping.beams) + np.asarray(rows, "<f4").tobytes()
