"""Everything a line or file may throw at the sonar link ends in a counter, and the next good ping is decoded."""

import math
import struct
from collections.abc import Callable

import numpy as np
import pytest

from ods.messages import frame_of
from ods.sonar_link.s7k import records
from ods.sonar_link.s7k.drf import encode_record
from tests.sonar_link.sonar_samples import UTC_NS, link, make_ping

GOOD = make_ping(1)
NEXT = make_ping(2)


def records_of(wire: bytes) -> list[bytes]:
    """Cut the wire form of a ping into its three frames."""
    frames, at = [], 0
    while at < len(wire):
        size = int.from_bytes(wire[at + 8 : at + 12], "little")
        frames.append(wire[at : at + size])
        at += size
    return frames


def with_body(frame: bytes, change: Callable[[bytearray], None]) -> bytes:
    """Change a record's body under a right checksum."""
    body = bytearray(frame[64:-4])
    change(body)
    return encode_record(int.from_bytes(frame[32:36], "little"), bytes(body), UTC_NS, records.DEVICE)


def with_beam_rows(vertical: list[float], horizontal: list[float]) -> bytes:
    settings, _, samples = records_of(records.encode_ping(GOOD))
    rows = np.array([vertical, horizontal, [0.0] * len(vertical), [0.03] * len(vertical)], "<f4")
    geometry = struct.pack("<QI", 0, len(vertical)) + rows.tobytes()
    return settings + encode_record(records.BEAM_GEOMETRY, geometry, UTC_NS, records.DEVICE) + samples


def with_settings_field(offset: int, value: float) -> bytes:
    settings, geometry, samples = records_of(records.encode_ping(GOOD))
    changed = with_body(settings, lambda body: struct.pack_into("<f", body, offset, value))
    return changed + geometry + samples


def expect(bad: bytes, **counters: int) -> None:
    """Send `bad` between nothing and a good ping."""
    pings, counted = link([bad, records.encode_ping(NEXT)])
    assert [ping.ping_number for ping in pings] == [NEXT.ping_number]
    np.testing.assert_array_equal(frame_of(pings[0]), frame_of(NEXT))
    assert {name: counted[name] for name in counters} == counters


def test_random_bytes() -> None:
    noise = np.random.default_rng(0).bytes(100_000)
    expect(noise, garbage_bytes=len(noise), records=3)


@pytest.mark.parametrize("record", [0, 1, 2])
def test_truncated_frames(record: int) -> None:
    frames = records_of(records.encode_ping(GOOD))
    frames[record] = frames[record][:-9]
    lost = "data_without_settings" if record == 0 else "data_without_geometry"
    expect(b"".join(frames), bad_checksum=1, garbage_bytes=len(frames[record]), **({lost: 1} if record < 2 else {}))


@pytest.mark.parametrize("record", [0, 1, 2])
def test_wrong_checksums(record: int) -> None:
    frames = records_of(records.encode_ping(GOOD))
    frames[record] = frames[record][:-20] + bytes([frames[record][-20] ^ 1]) + frames[record][-19:]
    expect(b"".join(frames), bad_checksum=1, garbage_bytes=len(frames[record]))


@pytest.mark.parametrize("size", [2**32 - 2, 2**31, 4 * 1024 * 1024 + 1])
def test_sizes_of_4_gb(size: int) -> None:
    frame = bytearray(records_of(records.encode_ping(GOOD))[2])
    frame[8:12] = size.to_bytes(4, "little")
    expect(bytes(frame), overlong_record=1, garbage_bytes=len(frame))


def test_sizes_of_4_gb_inside_a_record() -> None:
    """Counts of beams and samples that no record can hold."""
    frames = records_of(records.encode_ping(GOOD))
    beams = with_body(frames[1], lambda body: struct.pack_into("<I", body, 8, 2**32 - 1))
    samples = with_body(frames[2], lambda body: struct.pack_into("<I", body, 44 + 2, 2**32 - 1))
    expect(frames[0] + beams + frames[2], bad_beam_table=1, data_without_geometry=1)
    expect(frames[0] + frames[1] + samples, bad_water_column=1)


@pytest.mark.parametrize(
    ("vertical", "horizontal"),
    [
        ([0.0] * 6, [-0.2, -0.1, math.nan, 0.1, 0.2, 0.3]),
        ([0.0] * 6, [-0.2, -0.1, 0.0, 0.1, 0.2, math.inf]),
        ([0.0, math.nan, 0.0, 0.0, 0.0, 0.0], [-0.2, -0.1, 0.0, 0.1, 0.2, 0.3]),
        ([0.0] * 6, [-0.2, -0.1, 0.0, 0.1, 0.2, 3.2]),
        ([0.0] * 6, [-0.2, -0.1, 0.1, 0.0, 0.2, 0.3]),
        ([0.0] * 6, [0.1] * 6),
        ([1.6] * 6, [-0.2, -0.1, 0.0, 0.1, 0.2, 0.3]),
        ([0.0, 0.0, 0.0, 0.0, 0.1, 0.1], [-0.2, -0.1, 0.0, -0.2, -0.1, 0.0]),
    ],
)
def test_nan_and_absurd_beam_tables(vertical: list[float], horizontal: list[float]) -> None:
    expect(with_beam_rows(vertical, horizontal), bad_beam_table=1, data_without_geometry=1)


def test_a_signalling_nan_in_a_beam_table_is_no_warning() -> None:
    """numpy warns where it converts one; tests take warnings as errors."""
    frames = records_of(records.encode_ping(GOOD))
    beams = with_body(frames[1], lambda body: struct.pack_into("<I", body, 12 + 4 * GOOD.beams, 0x7F800001))
    expect(frames[0] + beams + frames[2], bad_beam_table=1, data_without_geometry=1)


def test_a_beam_table_of_another_number_of_beams() -> None:
    expect(with_beam_rows([0.0] * 5, [-0.2, -0.1, 0.0, 0.1, 0.2]), bad_ping=1)


def test_an_absurd_beam_table_never_brings_an_older_one_back() -> None:
    first = records.encode_ping(make_ping(0))
    pings, counters = link([first, with_beam_rows([0.0] * 6, [math.nan] * 6), records.encode_ping(NEXT)])
    assert [ping.ping_number for ping in pings] == [0, 2]
    assert (counters["data_without_geometry"], counters["lost_pings"]) == (1, 1)


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, 1e30])
@pytest.mark.parametrize("offset", [18, 142 + 4])
def test_absurd_sample_rate_and_sound_speed(offset: int, value: float) -> None:
    expect(with_settings_field(offset, value), bad_settings=1, data_without_settings=1)


def test_absurd_frequency_is_not_reported() -> None:
    pings, _ = link([with_settings_field(14, math.nan)])
    assert [ping.frequency_hz for ping in pings] == [0.0]


def test_absurd_first_sample() -> None:
    frames = records_of(records.encode_ping(GOOD))
    frames[2] = with_body(frames[2], lambda body: struct.pack_into("<I", body, 28, 2**32 - 1))
    expect(b"".join(frames), bad_ping=1)


def test_no_beams() -> None:
    frames = records_of(records.encode_ping(GOOD))
    frames[2] = with_body(frames[2], lambda body: struct.pack_into("<H", body, 14, 0))
    expect(b"".join(frames), bad_water_column=1)


def test_unknown_record_types() -> None:
    unknown = [encode_record(number, b"x" * 40, UTC_NS, records.DEVICE) for number in (0, 1003, 7027, 2**32 - 1)]
    expect(b"".join(unknown), other_records=4)


def test_any_single_flipped_bit_costs_one_ping_at_most() -> None:
    wire = records.encode_ping(GOOD)
    rng = np.random.default_rng(3)
    for at in rng.integers(0, len(wire), 300):
        flipped = bytearray(wire)
        flipped[at] ^= 1 << int(rng.integers(8))
        pings, _ = link([bytes(flipped), records.encode_ping(NEXT)])
        assert pings[-1].ping_number == NEXT.ping_number
        assert frame_of(pings[-1]).tolist() == frame_of(NEXT).tolist()
