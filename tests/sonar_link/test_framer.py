"""The framer: every chunking alike, no true record lost to garbage, every byte accounted for, bounded cost."""

import struct
import tracemalloc
from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from ods.sonar_link.s7k.drf import SYNC_WORD, DeviceId, S7kRecord, decode_time, encode_record, encode_time
from ods.sonar_link.s7k.framer import RecordFramer
from tests.sonar_link.sonar_samples import UTC_NS


def by_hand(body: bytes, flags: int = 1, size: int | None = None, version: int = 5, offset: int = 60) -> bytes:
    """A frame put together field by field from Table 5 of the format document."""
    frame = struct.pack("<HHI", version, offset, 0x0000FFFF)
    frame += struct.pack("<III", 64 + len(body) + 4 if size is None else size, 0, 0)
    frame += struct.pack("<HHfBB", 2020, 126, 56.5, 12, 34)
    frame += struct.pack("<HIIHHIHHIII", 1, 7042, 7128, 0, 3, 0, flags, 0, 0, 0, 0)
    frame += body
    return frame + struct.pack("<I", sum(frame) & 0xFFFFFFFF)


def bodies_of(records: list[S7kRecord]) -> list[bytes]:
    return [record.body for record in records]


bodies = st.binary(max_size=200)
fake_headers = st.builds(
    lambda size, tail: by_hand(b"", size=size)[:64] + tail,
    st.one_of(st.integers(0, 400), st.sampled_from([67, 68, 2**31, 2**32 - 1])),
    st.binary(max_size=80),
)
cut_frames = st.builds(lambda body, end: by_hand(body)[:end], bodies, st.integers(54, 70))
damaged_frames = st.builds(lambda body: by_hand(body)[:-5] + b"\x00\xff\x00\xff\x00", bodies)
garbage = st.lists(st.one_of(st.binary(max_size=40), st.just(SYNC_WORD), fake_headers, cut_frames, damaged_frames)).map(
    b"".join
)


def test_a_frame_made_by_hand() -> None:
    (record,) = RecordFramer().feed(by_hand(b"body"))
    assert (record.record_type, record.device, record.body) == (7042, (7128, 3), b"body")
    assert record.time_ns == 1_588_682_096_500_000_000  # date -d '2020-05-05 12:34:56.5 UTC' +%s%N


def test_the_encoder_writes_what_the_document_says() -> None:
    made = encode_record(7042, b"body", 1_588_682_096_500_000_000, device=DeviceId(7128, 3))
    assert made == by_hand(b"body")


@given(st.lists(bodies, max_size=4), garbage, st.lists(st.integers(0, 1500), max_size=12))
def test_chunking_does_not_matter(contents: list[bytes], noise: bytes, cuts: list[int]) -> None:
    stream = noise + noise.join(by_hand(body) for body in contents)
    whole, parts = RecordFramer(), RecordFramer()
    edges = sorted({0, *(min(cut, len(stream)) for cut in cuts), len(stream)})
    records = [r for i, j in pairwise(edges) for r in parts.feed(stream[i:j])] + parts.flush()
    assert records == whole.feed(stream) + whole.flush()
    assert parts.counters == whole.counters


@given(st.lists(st.tuples(garbage, bodies), min_size=1, max_size=4), garbage)
def test_garbage_costs_no_whole_frame_and_every_byte_is_accounted_for(
    parts: list[tuple[bytes, bytes]], tail: bytes
) -> None:
    framer = RecordFramer()
    frames = [by_hand(body) for _, body in parts]
    stream = b"".join(noise + frame for (noise, _), frame in zip(parts, frames, strict=True)) + tail
    records = framer.feed(stream) + framer.flush()
    found = bodies_of(records)
    for _, body in parts:  # in order; garbage may hold whole frames of its own
        found = found[found.index(body) + 1 :]
    assert framer.counters["records"] == len(records)
    assert framer.counters["garbage_bytes"] + sum(68 + len(record.body) for record in records) == len(stream)


@given(st.lists(st.integers(1, 90), min_size=1, max_size=30))
def test_arrival_times_are_those_of_the_chunks(sizes: list[int]) -> None:
    stream = b"noise" + by_hand(b"a" * 50) + by_hand(b"b" * 120) + b"?" * sum(sizes)
    framer, records, time_of_byte, at = RecordFramer(), list[S7kRecord](), list[int](), 0
    for t_ns, size in enumerate([*sizes, len(stream)]):
        chunk = stream[at : at + size]
        records += framer.feed(chunk, t_ns)
        time_of_byte += [t_ns] * len(chunk)
        at += len(chunk)
    first, second = records
    assert (first.first_ns, first.last_ns) == (time_of_byte[5], time_of_byte[5 + 117])
    assert (second.first_ns, second.last_ns) == (time_of_byte[123], time_of_byte[123 + 187])


@pytest.mark.parametrize(
    ("frame", "counter"),
    [
        (by_hand(b"x" * 30, version=4), "bad_version"),
        (by_hand(b"x" * 30, offset=59), "bad_offset"),
        (by_hand(b"x" * 30, offset=60 + 31), "bad_offset"),
        (by_hand(b"x" * 30, size=67), "short_record"),
        (by_hand(b"x" * 30, size=0xF0000000), "overlong_record"),
        (by_hand(b"x" * 30)[:-1] + b"\xff", "bad_checksum"),
        (by_hand(b"x" * 30)[:-1], "truncated_record"),
    ],
)
def test_each_kind_of_loss_has_its_counter(frame: bytes, counter: str) -> None:
    framer = RecordFramer(max_record_bytes=1000)
    records = framer.feed(frame) + framer.feed(by_hand(b"good")) + framer.flush()
    if counter == "truncated_record":  # the good frame's first byte completes it: the checksum tells
        counter = "bad_checksum"
    assert bodies_of(records) == [b"good"]
    assert framer.counters == {counter: 1, "records": 1, "garbage_bytes": len(frame)}


def test_a_record_without_checksum_is_taken_and_counted() -> None:
    framer = RecordFramer()
    assert bodies_of(framer.feed(by_hand(b"body", flags=0)[:-4] + b"\x12\x34\x56\x78")) == [b"body"]
    assert framer.counters == {"records": 1, "unchecked_records": 1}


@pytest.mark.parametrize("end", [12, 20, 40, 53])
def test_a_frame_cut_in_its_header_does_not_borrow_the_next_frames_flags(end: int) -> None:
    framer = RecordFramer()
    records = framer.feed(by_hand(b"lost" * 20)[:end] + by_hand(b"good" * 30)) + framer.flush()
    assert bodies_of(records) == [b"good" * 30]


def test_optional_data_are_left_out() -> None:
    frame = bytearray(by_hand(b"bodyoptional"))
    frame[12:16] = (68).to_bytes(4, "little")
    frame[-4:] = (sum(frame[:-4]) & 0xFFFFFFFF).to_bytes(4, "little")
    assert bodies_of(RecordFramer().feed(frame)) == [b"body"]


def test_a_header_that_claims_4_gb_allocates_nothing_and_holds_up_nothing() -> None:
    framer = RecordFramer()
    tracemalloc.start()
    try:
        records = framer.feed(by_hand(b"", size=2**32 - 1)[:64] + by_hand(b"good"))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert bodies_of(records) == [b"good"]
    assert peak < 1_000_000


def test_a_record_that_stops_in_the_middle_is_given_up_on_request() -> None:
    framer = RecordFramer()
    assert framer.feed(by_hand(b"x" * 100)[:120], 7) == []
    before = framer.waiting_since_ns
    assert framer.give_up() == []
    assert (before, framer.waiting_since_ns, framer.counters["truncated_record"]) == (7, None, 1)
    assert bodies_of(framer.feed(by_hand(b"good"))) == [b"good"]


def test_missing_bytes_are_what_the_record_under_way_still_needs() -> None:
    frame, framer = by_hand(b"x" * 100), RecordFramer()
    reported = []
    for at in range(len(frame)):
        reported.append(framer.missing_bytes)
        framer.feed(frame[at : at + 1])
    assert reported == [0] * 64 + list(range(104, 0, -1))  # nothing is known before the header is whole
    assert framer.missing_bytes == 0


def test_many_false_headers_over_the_same_bytes_stay_cheap() -> None:
    """Each of 20,000 headers claims 1 MB: adding them up one by one would take minutes."""
    framer = RecordFramer()
    stream = by_hand(b"", size=1_000_000)[:64] * 20_000 + by_hand(b"good")
    records = [r for at in range(0, len(stream), 4096) for r in framer.feed(stream[at : at + 4096])]
    assert bodies_of(records + framer.flush()) == [b"good"]


@given(st.integers(0, 7_000_000_000_000_000_000))
def test_time_round_trip(utc_ns: int) -> None:
    reported = decode_time(encode_time(utc_ns))
    assert reported is not None
    assert abs(reported - utc_ns) <= 2000


@pytest.mark.parametrize(
    "fields",
    [(0, 0, 0.0, 0, 0), (2020, 0, 0.0, 0, 0), (2020, 367, 0.0, 0, 0), (2020, 1, float("nan"), 0, 0),
     (2020, 1, 61.0, 0, 0), (2020, 1, -1.0, 0, 0), (2020, 1, 0.0, 24, 0), (2020, 1, 0.0, 0, 60), (60000, 1, 0.0, 0, 0)],
)  # fmt: skip
def test_no_time_and_absurd_times_are_none(fields: tuple[int, int, float, int, int]) -> None:
    assert decode_time(struct.pack("<HHfBB", *fields)) is None


def test_times_the_format_cannot_carry_are_refused() -> None:
    assert decode_time(encode_time(None)) is None
    assert decode_time(encode_time(UTC_NS)) == UTC_NS
    for utc_ns in (-1, 10**19):
        with pytest.raises(ValueError, match="utc_ns"):
            encode_time(utc_ns)
