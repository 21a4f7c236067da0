"""Records 7000, 7004, 7018, 7042: layouts put together by hand from the format document, and round trips."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.messages import Ping, SampleType, Scale, frame_of
from ods.sonar_link.ping_builder import BeamTable
from ods.sonar_link.s7k import records
from ods.sonar_link.s7k.drf import DeviceId, S7kRecord
from ods.sonar_link.s7k.loss import Loss
from ods.sonar_link.s7k.water_column import WaterColumn
from ods.sonar_link.setting_requests import Controls
from tests.sonar_link.sonar_samples import link, make_ping

RATE_HZ = 3000.0  # with 1500 m/s: 0.25 m a sample


def decode(record_type: int, body: bytes) -> records.Content | Loss:
    decoded = records.decode(S7kRecord(record_type, DeviceId(7128), None, body))
    assert decoded is not None
    return decoded


def decode_samples(record_type: int, body: bytes) -> WaterColumn:
    decoded = decode(record_type, body)
    assert isinstance(decoded, WaterColumn)
    return decoded


def body_7042(flags: int, beams: list[bytes], first: int = 0, rate: float = RATE_HZ, factor: float = 0.0) -> bytes:
    return (
        struct.pack("<QIHHIIIIff", 9, 5, 0, len(beams), 3, 3, flags, first, rate, factor) + bytes(4) + b"".join(beams)
    )


def test_settings_field_by_field() -> None:
    fields = [struct.pack("<QIH", 9, 77, 2), struct.pack("<ff", 455e3, 15000.0), bytes(8), bytes(16)]
    fields += [bytes(8), struct.pack("<fff", 60.0, 208.0, 25.5)]  # ping rate and period; range, power, gain
    fields += [bytes(4), bytes(4 + 5 * 4 + 4 + 4 + 4), bytes(20), bytes(16)]  # ..., bottom detection
    fields += [struct.pack("<fff", 100.0, 1481.5, 30.0), bytes(2)]
    body = b"".join(fields)
    assert len(body) == 156
    assert decode(7000, body) == records.SettingsRecord(77, 2, 455e3, 15000.0, 1481.5, Controls(60.0, 208.0, 25.5))
    assert decode(7000, body + b"later versions append") == decode(7000, body)


def test_beam_geometry_vertical_before_horizontal_along_before_across() -> None:
    rows = [[0.1, 0.1], [-0.5, 0.5], [0.3, 0.3], [0.02, 0.03]]
    table = decode(7004, struct.pack("<QI", 9, 2) + np.array(rows, "<f4").tobytes())
    assert isinstance(table, BeamTable)
    np.testing.assert_allclose(table.bearing_rad, [-0.5, 0.5])
    np.testing.assert_allclose(table.elevation_rad, [0.1, 0.1])
    np.testing.assert_allclose(table.width_rad, [0.02, 0.03], rtol=1e-6)


def test_7018_comes_sample_by_sample() -> None:
    body = struct.pack("<QIHHI", 9, 5, 0, 2, 3) + bytes(32)
    for amplitude in (1, 10, 2, 20, 3, 65535):
        body += struct.pack("<Hh", amplitude, -7)
    data = decode_samples(7018, body)
    np.testing.assert_array_equal(data.frame, [[1, 2, 3], [10, 20, 65535]])
    assert (data.scale, data.sample_rate_hz, data.first_sample) == ("linear", None, 0.0)


@pytest.mark.parametrize(
    ("flags", "sample", "expected", "scale"),
    [
        (0, "<Hh", np.uint16, "linear"),
        (1 << 1, "<H", np.uint16, "linear"),
        (1 << 2, "<Bb", np.uint8, "log8"),
        (1 << 1 | 1 << 2, "<B", np.uint8, "log8"),
        (1 << 12, "<fb", np.float32, "linear"),
        (1 << 12 | 1 << 1, "<f", np.float32, "linear"),
    ],
)
@pytest.mark.parametrize("segments", [False, True])
def test_7042_in_all_six_layouts(flags: int, sample: str, expected: type, scale: str, segments: bool) -> None:
    rows = [[1, 2, 3], [4, 5, 250]]
    beams = []
    for number, row in enumerate(rows):
        beam = struct.pack("<HBI", number, 1, 3) if segments else struct.pack("<HI", number, 3)
        phase = () if flags & 1 << 1 else (-1,)
        beams.append(beam + b"".join(struct.pack(sample, value, *phase) for value in row))
    data = decode_samples(7042, body_7042(flags | (1 << 14 if segments else 0), beams))
    assert data.frame.dtype == np.dtype(expected)
    np.testing.assert_array_equal(data.frame, rows)
    assert (data.ping_number, data.scale) == (5, scale)
    assert data.scale_factor == (40.0 if scale == "log8" else 1.0)


def test_7042_beams_cut_at_different_ranges_end_in_zeros() -> None:
    beams = [struct.pack("<HI3B", 4, 3, 7, 8, 9), struct.pack("<HI", 5, 0), struct.pack("<HI1B", 6, 1, 1)]
    data = decode_samples(7042, body_7042(0b111, beams))
    np.testing.assert_array_equal(data.frame, [[7, 8, 9], [0, 0, 0], [1, 0, 0]])
    assert data.beam_numbers is not None
    assert data.beam_numbers.tolist() == [4, 5, 6]


def test_7042_first_sample_and_down_sampling() -> None:
    """Of windows of 5, sample 2 is the middle: 0.4 of the new spacing behind the window's first sample."""
    beam = [struct.pack("<HI3B", 0, 3, 7, 8, 9)]
    data = decode_samples(7042, body_7042(0b110 | 5 << 4 | 0x300 | 1 << 13, beam, first=10, rate=600.0, factor=30.0))
    assert (data.first_sample, data.sample_rate_hz, data.scale_factor) == (10.4, 600.0, 30.0)
    plain = decode_samples(7042, body_7042(0b110 | 5 << 4, beam, first=10, factor=30.0))
    assert (plain.first_sample, plain.scale_factor) == (10.0, 40.0)


@pytest.mark.parametrize(
    ("record_type", "body", "counter"),
    [
        (7000, bytes(155), "bad_settings"),
        (7000, bytes(156), "bad_settings"),
        (7004, bytes(11), "bad_beam_table"),
        (7004, struct.pack("<QI", 0, 0), "bad_beam_table"),
        (7004, struct.pack("<QI", 0, 2**32 - 1) + bytes(160), "bad_beam_table"),
        (7018, bytes(51), "bad_water_column"),
        (7018, bytes(52), "bad_water_column"),
        (7018, struct.pack("<QIHHI", 0, 0, 0, 2, 3) + bytes(32 + 23), "bad_water_column"),
        (7018, struct.pack("<QIHHI", 0, 0, 0, 65535, 2**32 - 1) + bytes(32), "bad_water_column"),
        (7042, bytes(43), "bad_water_column"),
        (7042, body_7042(0b110, []), "bad_water_column"),
        (7042, body_7042(0b110, [b"\0"]), "bad_water_column"),
        (7042, body_7042(0b110, [struct.pack("<HI2B", 0, 3, 7, 8)]), "bad_water_column"),
        (7042, body_7042(0b110, [struct.pack("<HI3B", 0, 2**32 - 1, 7, 8, 9)]), "bad_water_column"),
        (7042, body_7042(0b110, [struct.pack("<HI", 0, 0)]), "bad_water_column"),
        (7042, body_7042(0b110, [struct.pack("<HIB", 0, 1, 7)], rate=math.nan), "bad_water_column"),
        (7042, body_7042(0b110 | 1 << 13, [struct.pack("<HIB", 0, 1, 7)], factor=math.nan), "bad_water_column"),
        (7042, body_7042(1 << 12 | 2, [struct.pack("<HIf", 0, 1, math.inf)]), "bad_water_column"),
        (7042, body_7042(1 << 12 | 1 << 2, [bytes(20)]), "unsupported_layout"),
        (7042, body_7042(1 << 15, [bytes(20)]), "unsupported_layout"),
    ],
)
def test_what_cannot_be_used_names_its_counter(record_type: int, body: bytes, counter: str) -> None:
    assert decode(record_type, body) is Loss(counter)


def test_many_beams_of_which_one_is_long_do_not_blow_up() -> None:
    """65535 beams, 60000 samples in one of them: 4 GB if padded."""
    beams = [struct.pack("<HI", 0, 1) + b"\1"] * 4000 + [struct.pack("<HI", 1, 60000) + bytes(60000)]
    assert decode(7042, body_7042(0b110, beams)) is Loss.BAD_WATER_COLUMN


@given(st.sampled_from([7000, 7004, 7018, 7042]), st.binary(max_size=400))
def test_random_bodies_are_decoded_or_rejected(record_type: int, body: bytes) -> None:
    decode(record_type, body)


@given(st.integers(0, 2**16), st.binary(min_size=1, max_size=120), st.integers(0, 60), st.integers(1, 6))
def test_random_water_columns_are_decoded_or_rejected(flags: int, tail: bytes, samples: int, beams: int) -> None:
    body = struct.pack("<QIHHIIIIff", 9, 5, 0, beams, 3, 3, flags, 0, RATE_HZ, 0.0) + bytes(4)
    body += struct.pack("<HBI" if flags & 1 << 14 else "<HI", 0, *([0] if flags & 1 << 14 else []), samples) + tail
    data = decode(7042, body)
    if isinstance(data, WaterColumn):
        assert data.frame.shape[0] == beams
        assert data.frame.size * 4 <= 4 * beams * len(body)
    else:
        assert isinstance(data, Loss)


@pytest.mark.parametrize(
    ("dtype", "scale", "factor", "range0_m", "record_type"),
    [
        ("u1", "log8", 40.0, 0.5, 7042),
        ("u1", "log8", 31.5, 0.0, 7042),
        ("u2", "linear", 1.0, 0.0, 7018),
        ("u2", "linear", 1.0, 0.75, 7042),
        ("f4", "linear", 1.0, 0.0, 7042),
    ],
)
@pytest.mark.parametrize("planes", [1, 3])
def test_round_trip(
    dtype: SampleType, scale: Scale, factor: float, range0_m: float, record_type: int, planes: int
) -> None:
    ping = make_ping(7, dtype=dtype, scale=scale, scale_factor=factor, range0_m=range0_m, planes=planes)
    wire = records.encode_ping(ping)
    assert struct.pack("<I", record_type) in wire
    (back,), counters = link([wire])
    assert frame_of(back).tolist() == frame_of(ping).tolist()
    same = [name for name in Ping.__struct_fields__ if name not in ("seq", "t_rx_ns", "data", "setting")]
    assert back.setting == "power 0 dB, gain 0 dB"
    assert [getattr(back, name) for name in same] == [getattr(ping, name) for name in same]
    assert counters == {"records": 3, "pings": 1}


def test_pings_that_the_format_cannot_carry_are_refused() -> None:
    with pytest.raises(ValueError, match="scale db"):
        records.encode_ping(make_ping(scale="db", scale_factor=0.3))
    with pytest.raises(ValueError, match="not a multiple"):
        records.encode_ping(make_ping(range0_m=0.3))
