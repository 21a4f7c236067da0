"""Network frames: the layout, any chunking and packet size, and what garbage, cuts and lies in headers cost."""

import struct
from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from ods.sonar_link.s7k.drf import DeviceId, encode_record
from ods.sonar_link.s7k.framer import RecordFramer
from ods.sonar_link.s7k.network_frame import HEADER_START, PACKET_HEADER_BYTES, Deframer, frame_record
from tests.sonar_link.sonar_samples import UTC_NS

LIMIT = 1 << 20


def by_hand(data: bytes, *, packets: int = 1, size: int | None = None, total: int | None = None, nth: int = 0) -> bytes:
    """A packet put together field by field from the definition."""
    packet_size = 36 + len(data) if size is None else size
    header = struct.pack("<HHI", 5, 36, packets) + struct.pack("<HH", 1, 7)
    header += struct.pack("<III", packet_size, len(data) if total is None else total, nth)
    return header + struct.pack("<IHHI", 0, 0, 0, 0) + data


def record(number: int, length: int = 50) -> bytes:
    return encode_record(7000, number.to_bytes(4, "little") + bytes(length), UTC_NS, device=DeviceId(1))


def numbers(*streams: bytes) -> list[int]:
    """The records that come out of one stream after another, and its end."""
    deframer, framer = Deframer(LIMIT), RecordFramer(LIMIT)
    found = [r for stream in streams for r in framer.feed(deframer.feed(stream))]
    found += framer.feed(deframer.flush()) + framer.flush()
    return [int.from_bytes(r.body[:4], "little") for r in found]


def test_a_packet_made_by_hand() -> None:
    assert frame_record(b"a record", 7) == by_hand(b"a record")
    deframer = Deframer(LIMIT)
    assert deframer.feed(by_hand(b"a record")) == b"a record"
    assert deframer.counters == {"network_frames": 1}


def test_a_long_record_goes_into_numbered_packets() -> None:
    assert frame_record(b"abcdefg", 7, max_packet_bytes=39) == (
        by_hand(b"abc", packets=3, total=7)
        + by_hand(b"def", packets=3, total=7, nth=1)
        + by_hand(b"g", packets=3, total=7, nth=2)
    )


bytes_with_headers = st.lists(
    st.one_of(
        st.binary(max_size=60),
        st.just(HEADER_START),
        st.builds(by_hand, st.binary(max_size=40)),
        st.builds(lambda data, cut: by_hand(data)[:cut], st.binary(max_size=40), st.integers(0, 70)),
        st.builds(lambda size, total: by_hand(b"x", size=size, total=total), *[st.integers(0, 2**32 - 1)] * 2),
    ),
    max_size=6,
).map(b"".join)


@given(bytes_with_headers, st.lists(st.integers(0, 500), max_size=12))
def test_chunking_does_not_matter_and_no_byte_is_lost(stream: bytes, cuts: list[int]) -> None:
    edges = sorted({0, *(min(cut, len(stream)) for cut in cuts), len(stream)})
    whole, parts = Deframer(LIMIT), Deframer(LIMIT)
    joined = b"".join(parts.feed(stream[i:j]) for i, j in pairwise(edges)) + parts.flush()
    assert joined == whole.feed(stream) + whole.flush()
    assert parts.counters == whole.counters
    assert len(stream) == len(joined) + PACKET_HEADER_BYTES * whole.counters["network_frames"]


@given(
    st.lists(st.integers(0, 300), min_size=1, max_size=5),
    st.integers(PACKET_HEADER_BYTES + 1, 500),
    st.lists(st.integers(0, 3000), max_size=12),
)
def test_records_of_any_length_come_through_packets_of_any_length(
    lengths: list[int], packet: int, cuts: list[int]
) -> None:
    stream = b"".join(frame_record(record(n, length), n, packet) for n, length in enumerate(lengths))
    edges = sorted({0, *(min(cut, len(stream)) for cut in cuts), len(stream)})
    assert numbers(*(stream[i:j] for i, j in pairwise(edges))) == list(range(len(lengths)))


@given(st.binary(max_size=200), st.binary(max_size=200))
def test_garbage_between_packets_costs_no_record(before: bytes, between: bytes) -> None:
    stream = before + frame_record(record(1), 1) + between + frame_record(record(2), 2)
    assert numbers(stream) == [1, 2]


@given(st.integers(0, len(frame_record(record(1), 1)) - 1))
def test_a_packet_cut_anywhere_costs_one_record(cut: int) -> None:
    """The packet behind it is swallowed as its data, but the record in there is found all the same."""
    stream = frame_record(record(1), 1)[:cut] + frame_record(record(2), 2) + frame_record(record(3), 3)
    assert numbers(stream) == [2, 3]


@pytest.mark.parametrize("lie", [-1, -40, 1, 30, 200])
def test_a_wrong_packet_size_costs_nothing(lie: int) -> None:
    data = record(1)
    lying = by_hand(data, size=36 + len(data) + lie, total=len(data) + max(lie, 0))
    assert numbers(lying + frame_record(record(2), 2) + frame_record(record(3), 3)) == [1, 2, 3]


@pytest.mark.parametrize(
    "header",
    [
        by_hand(b"", size=36, total=0),
        by_hand(b"x", size=35),
        by_hand(b"x", size=2**32 - 1, total=2**32 - 1),
        by_hand(b"x", total=LIMIT + 1),
        by_hand(b"x", packets=0),
        by_hand(b"x", nth=1),
        by_hand(b"xy", total=1),
    ],
)
def test_a_header_that_cannot_be_one_is_handed_on_as_data(header: bytes) -> None:
    deframer = Deframer(LIMIT)
    assert deframer.feed(header) + deframer.flush() == header
    assert deframer.counters == Counter(unframed_bytes=len(header))


def test_the_next_connection_begins_afresh() -> None:
    deframer = Deframer(LIMIT)
    deframer.feed(by_hand(b"0123456789")[:-3])
    assert deframer.flush() == b""
    assert deframer.feed(by_hand(b"next")) == b"next"


def lying_packet(data: bytes, size: int, packets: int, nth: int) -> bytes:
    return by_hand(data, packets=packets, size=size, total=size, nth=nth)


lies = st.lists(
    st.one_of(
        st.builds(lying_packet, st.binary(max_size=60), st.integers(37, LIMIT), st.integers(1, 9), st.integers(0, 8)),
        st.builds(lying_packet, st.just(record(9)), st.integers(37, LIMIT), st.just(1), st.just(0)),
        st.builds(lambda cut: frame_record(record(9, 300), 9, 100)[:cut], st.integers(0, 600)),
        st.binary(max_size=60),
    ),
    max_size=5,
).map(b"".join)


@given(lies, st.lists(st.integers(0, 6000), max_size=12))
def test_lies_of_any_length_cost_one_record_of_many_packets_at_most(reported: bytes, cuts: list[int]) -> None:
    """A frame that claimed 4 MB cost all pings of more than one packet for as long: 4 s at 1 MB/s."""
    records = [record(number, 1000) for number in range(5)]
    stream = reported + b"".join(frame_record(each, number, 200) for number, each in enumerate(records))
    edges = sorted({0, *(min(cut, len(stream)) for cut in cuts), len(stream)})
    deframer = Deframer(LIMIT)
    joined = b"".join(deframer.feed(stream[i:j]) for i, j in pairwise(edges))
    assert [each in joined for each in records[1:]] == [True] * 4


def test_a_frame_that_claims_4_mb_costs_no_ping_behind_its_own() -> None:
    pings = [frame_record(record(number, 120_000), number) for number in range(4)]
    lying = by_hand(pings[0][36:60_000], packets=3, size=LIMIT, total=LIMIT)
    assert numbers(lying + b"".join(pings[1:])) == [1, 2, 3]
