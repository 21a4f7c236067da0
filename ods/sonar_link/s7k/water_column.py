"""Amplitudes in s7k records 7018 (beamformed data) and 7042 (compressed water column), both ways.

Source: 7k Data Format Definition 3.12, sections 10.36 and 10.47, appendix I. The document does not say what the 32-bit
magnitudes of record 7042 are; public readers of recorded files (CoFFee, themachinethatgoesping) take them for float32,
and so does this module. Phase is left out.
"""

import math
import struct
from dataclasses import dataclass, field

import numpy as np

from ods.base.arrays import AnyArray, Indices
from ods.messages import Ping, Scale, frame_of
from ods.sonar_link.ping_builder import MAX_BEAMS, MAX_FRAME_BYTES, MAX_SAMPLES, Runs, runs_beyond
from ods.sonar_link.s7k.loss import Loss, RecordError

DEFAULT_LOG_FACTOR = 40.0
"""a = floor(F log10(magnitude) + 0.5) with this F where the record brings none (appendix I)."""

MAGNITUDE_ONLY = 1 << 1
EIGHT_BIT_LOG = 1 << 2
FLOAT_MAGNITUDE = 1 << 12
FACTOR_GIVEN = 1 << 13
SEGMENTS_GIVEN = 1 << 14
FIRST_SAMPLE_IS_DELAY = 1 << 15
_DIVISOR = 0xF0, 4
_DOWNSAMPLING = 0xF00

_HEADER_7018 = struct.Struct("<QIHHI32x")
_HEADER_7042 = struct.Struct("<QIHHIIIIff4x")
_BEAM_HEAD = struct.Struct("<HI")
"""Without segment number."""
_AMPLITUDE_AND_PHASE = np.dtype([("magnitude", "<u2"), ("phase", "<i2")])


@dataclass(frozen=True, eq=False)
class WaterColumn:
    """The samples of one ping."""

    ping_number: int
    multi_ping: int
    beam_numbers: Indices | None
    """(beams,) rows of the beam table; None: all of it."""
    frame: AnyArray
    """(beams, samples) uint8, uint16 or float32, any memory order; beams cut short end in zeros,"""
    no_data: Runs = field(default_factory=list)
    """Listed here: see `Ping.no_data`."""
    scale: Scale = "linear"
    scale_factor: float = 1.0
    sample_rate_hz: float | None = None
    """After down-sampling; None when the sonar settings contain it."""
    first_sample: float = 0.0
    """Time of the first sample after transmission, in samples; the middle of its window when down-sampled."""


def decode_7018(body: bytes) -> WaterColumn:
    """Decode beamformed data: sample by sample, amplitude and phase of all beams. Raises RecordError."""
    if len(body) < _HEADER_7018.size:
        raise RecordError(Loss.BAD_WATER_COLUMN)
    _, ping_number, multi_ping, beams, samples = _HEADER_7018.unpack_from(body)
    _check_shape(beams, samples)
    if len(body) < _HEADER_7018.size + beams * samples * _AMPLITUDE_AND_PHASE.itemsize:
        raise RecordError(Loss.BAD_WATER_COLUMN)
    pairs = np.frombuffer(body, _AMPLITUDE_AND_PHASE, beams * samples, _HEADER_7018.size)
    frame = pairs["magnitude"].reshape(samples, beams).T
    return WaterColumn(ping_number, multi_ping, None, frame)


def decode_7042(body: bytes) -> WaterColumn:
    """Decode compressed water column data: beam by beam, in one of six sample layouts. Raises RecordError."""
    if len(body) < _HEADER_7042.size:
        raise RecordError(Loss.BAD_WATER_COLUMN)
    _, ping_number, multi_ping, beams, _, _, flags, first, rate, factor = _HEADER_7042.unpack_from(body)
    if flags & FIRST_SAMPLE_IS_DELAY or (flags & FLOAT_MAGNITUDE and flags & EIGHT_BIT_LOG):
        raise RecordError(Loss.UNSUPPORTED_LAYOUT)
    if not math.isfinite(rate) or rate < 0.0:
        raise RecordError(Loss.BAD_WATER_COLUMN)
    beam_numbers, frame, no_data = _read_beams(body, beams, _sample_dtype(flags), bool(flags & SEGMENTS_GIVEN))
    if frame.dtype.kind == "f" and not np.isfinite(frame).all():
        raise RecordError(Loss.BAD_WATER_COLUMN)
    scale: Scale = "log8" if flags & EIGHT_BIT_LOG else "linear"
    if not flags & FACTOR_GIVEN:
        factor = DEFAULT_LOG_FACTOR
    if scale == "log8" and not 1e-3 < factor < 1e6:  # false for NaN too
        raise RecordError(Loss.BAD_WATER_COLUMN)
    return WaterColumn(
        ping_number, multi_ping, beam_numbers, frame, no_data, scale, factor if scale == "log8" else 1.0, rate or None,
        first + _window_middle(flags),
    )  # fmt: skip


def encode_7018(ping: Ping) -> bytes:
    """Return the body of record 7018, phase all zero; the ping starts at range 0 and has uint16 samples."""
    pairs = np.zeros((ping.samples, ping.beams), _AMPLITUDE_AND_PHASE)
    pairs["magnitude"] = frame_of(ping).T
    return _HEADER_7018.pack(0, ping.ping_number % 2**32, 0, ping.beams, ping.samples) + pairs.tobytes()


def encode_7042(ping: Ping, first_sample: int, sample_rate_hz: float) -> bytes:
    """Return the body of record 7042, magnitudes only: 8-bit logarithmic, 16-bit or float32 as the ping has them.

    A beam without data up to its end is cut short; other samples without data are written as they are.
    """
    flags = MAGNITUDE_ONLY
    factor = 0.0
    if ping.scale == "log8":
        flags |= EIGHT_BIT_LOG
        if ping.scale_factor != DEFAULT_LOG_FACTOR:
            flags, factor = flags | FACTOR_GIVEN, ping.scale_factor
    elif ping.dtype == "f4":
        flags |= FLOAT_MAGNITUDE
    ends = {beam: first for beam, first, stop in ping.no_data if stop == ping.samples}
    if len(ends) == ping.beams:  # samples that no beam has would be lost
        ends = {}
    header = _HEADER_7042.pack(
        0, ping.ping_number % 2**32, 0, ping.beams,
        ping.samples, ping.samples, flags, first_sample, sample_rate_hz, factor,
    )  # fmt: skip
    return header + (_uneven_beams(ping, flags, ends) if ends else _even_beams(ping, flags))


def _even_beams(ping: Ping, flags: int) -> bytes:
    beams = np.zeros(ping.beams, _beam_dtype(_sample_dtype(flags), False, ping.samples))
    beams["beam"] = np.arange(ping.beams)
    beams["samples"] = ping.samples
    beams["data"]["magnitude"] = frame_of(ping)
    return beams.tobytes()


def _uneven_beams(ping: Ping, flags: int, ends: dict[int, int]) -> bytes:
    """ends: samples of the beams that are cut short."""
    magnitude = _sample_dtype(flags)["magnitude"]
    parts = []
    for beam, row in enumerate(frame_of(ping)):
        count = ends.get(beam, ping.samples)
        parts += [_BEAM_HEAD.pack(beam, count), row[:count].astype(magnitude).tobytes()]
    return b"".join(parts)


def _check_shape(beams: int, samples: int) -> None:
    if not (1 <= beams <= MAX_BEAMS and 1 <= samples <= MAX_SAMPLES and beams * samples * 4 <= MAX_FRAME_BYTES):
        raise RecordError(Loss.BAD_WATER_COLUMN)


def _sample_dtype(flags: int) -> np.dtype[np.void]:
    if flags & FLOAT_MAGNITUDE:
        magnitude, phase = "<f4", "i1"
    elif flags & EIGHT_BIT_LOG:
        magnitude, phase = "u1", "i1"
    else:
        magnitude, phase = "<u2", "<i2"
    fields = [("magnitude", magnitude)]
    return np.dtype(fields if flags & MAGNITUDE_ONLY else [*fields, ("phase", phase)])


def _beam_dtype(sample: np.dtype[np.void], segments: bool, samples: int) -> np.dtype[np.void]:
    segment = [("segment", "u1")] if segments else []
    return np.dtype([("beam", "<u2"), *segment, ("samples", "<u4"), ("data", sample, (samples,))])


def _window_middle(flags: int) -> float:
    """Return how far, in samples after down-sampling by n, the middle of a window lies behind its first sample."""
    divisor = (flags & _DIVISOR[0]) >> _DIVISOR[1]
    if not flags & _DOWNSAMPLING or divisor < 2:
        return 0.0
    return 0.5 * (divisor - 1) / divisor


def _read_beams(body: bytes, beams: int, sample: np.dtype[np.void], segments: bool) -> tuple[Indices, AnyArray, Runs]:
    """Return the beam numbers, the (beams, samples) magnitudes behind the header of record 7042, and where none is."""
    head = _beam_dtype(sample, segments, 0)
    if len(body) < _HEADER_7042.size + head.itemsize:
        raise RecordError(Loss.BAD_WATER_COLUMN)
    samples = int(np.frombuffer(body, head, 1, _HEADER_7042.size)["samples"][0])
    _check_shape(beams, max(samples, 1))
    alike = _beam_dtype(sample, segments, samples)
    if len(body) >= _HEADER_7042.size + beams * alike.itemsize:
        table = np.frombuffer(body, alike, beams, _HEADER_7042.size)
        if samples and np.all(table["samples"] == samples):
            return table["beam"].astype(np.intp), table["data"]["magnitude"], []
    return _read_uneven_beams(body, beams, sample, head)


def _read_uneven_beams(
    body: bytes, beams: int, sample: np.dtype[np.void], head: np.dtype[np.void]
) -> tuple[Indices, AnyArray, Runs]:
    """Read beams that were cut at different ranges."""
    numbers = np.zeros(beams, np.intp)
    rows: list[AnyArray] = []
    at = _HEADER_7042.size
    for row in range(beams):
        if at + head.itemsize > len(body):
            raise RecordError(Loss.BAD_WATER_COLUMN)
        entry = np.frombuffer(body, head, 1, at)[0]
        at += head.itemsize
        count = int(entry["samples"])
        if at + count * sample.itemsize > len(body):
            raise RecordError(Loss.BAD_WATER_COLUMN)
        numbers[row] = entry["beam"]
        rows.append(np.frombuffer(body, sample, count, at)["magnitude"])
        at += count * sample.itemsize
    longest = max(row.size for row in rows)
    _check_shape(beams, longest)
    frame = np.zeros((beams, longest), sample["magnitude"])
    for row, values in enumerate(rows):
        frame[row, : values.size] = values
    return numbers, frame, runs_beyond([row.size for row in rows], longest)
