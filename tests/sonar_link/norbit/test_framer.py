"""Packets in a byte stream: any chunking, any damage; nothing raises, every byte is accounted for."""

import struct
from collections import Counter

import pytest
from hypothesis import given, strategies as st

from ods.sonar_link import sync_framer
from ods.sonar_link.norbit import framer as framer_module, packets
from ods.sonar_link.norbit.framer import Framer, fault_of
from ods.sonar_link.norbit.packets import Buffer, Header
from tests.sonar_link.norbit import wire

LIMIT = 20_000
GOOD = wire.image(wire.samples(1))
NEXT = wire.image(wire.samples(2), number=2)
UNCHECKED = wire.image(wire.samples(3), number=3, checksum=0)
BATHYMETRY = wire.sealed(bytes(88 + 20), 1)
PREAMBLE = bytes.fromhex("efbeadde")


def found(framer: Framer, stream: bytes) -> list[bytes]:
    return [packet.data for packet in framer.feed(stream) + framer.flush()]


def test_packets_of_all_kinds_and_arrivals() -> None:
    framer = Framer(LIMIT)
    assert framer.feed(GOOD[:50], 5) == []
    assert framer.waiting_since_ns == 5
    assert framer.missing_bytes == len(GOOD) - 50
    (first, second, third) = framer.feed(GOOD[50:] + BATHYMETRY + UNCHECKED, 7)
    assert [first.data, second.data, third.data] == [GOOD, BATHYMETRY, UNCHECKED]
    assert (first.first_ns, first.last_ns, second.first_ns) == (5, 7, 7)
    assert (first.header.kind, second.header.kind) == (2, 1)
    assert +framer.counters == {"records": 3}


@given(st.lists(st.sampled_from([GOOD, NEXT, UNCHECKED, BATHYMETRY, PREAMBLE, PREAMBLE[:3], b"noise", GOOD[:150]])),
       st.data())  # fmt: skip
def test_the_chunking_never_matters(parts: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(parts)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)))))
    whole, cut = Framer(LIMIT), Framer(LIMIT)
    expected = found(whole, stream)
    came = [
        packet.data for begin, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)
        for packet in cut.feed(stream[begin:end])
    ] + [packet.data for packet in cut.flush()]  # fmt: skip
    assert came == expected
    assert cut.counters == whole.counters
    assert sum(map(len, came)) + cut.counters["garbage_bytes"] == len(stream)


@given(st.lists(st.tuples(st.integers(0, len(GOOD) * 8 - 1)), min_size=1, max_size=5, unique=True))
def test_a_flipped_bit_never_becomes_a_packet(bits: list[tuple[int]]) -> None:
    """But for bits that the checksum does not cover and nothing reads: version and the reserved word."""
    spoilt = bytearray(GOOD)
    for (bit,) in bits:
        spoilt[bit // 8] ^= 1 << bit % 8
    unread = spoilt[:12] + spoilt[20:] == GOOD[:12] + GOOD[20:]
    framer = Framer(LIMIT)
    assert found(framer, bytes(spoilt) + NEXT) == ([bytes(spoilt)] if unread else []) + [NEXT]


@given(st.integers(0, len(GOOD) - 1), st.sampled_from([NEXT, UNCHECKED, BATHYMETRY]))
def test_a_packet_that_is_cut_costs_no_other(cut: int, following: bytes) -> None:
    framer = Framer(LIMIT)
    assert found(framer, GOOD[:cut] + following) == [following]
    assert framer.counters["garbage_bytes"] == cut


@given(st.integers(0, len(GOOD)), st.binary(min_size=1, max_size=300))
def test_a_packet_that_is_inflated_costs_no_other(at: int, more: bytes) -> None:
    framer = Framer(LIMIT)
    came = found(framer, GOOD[:at] + more + GOOD[at:] + NEXT)
    assert came[-1] == NEXT
    assert set(came) <= {GOOD, NEXT}


@given(st.binary(max_size=4000))
def test_random_bytes_never_raise_and_nothing_is_kept(noise: bytes) -> None:
    framer = Framer(LIMIT)
    found(framer, PREAMBLE + noise)
    assert framer.missing_bytes == 0
    assert found(framer, GOOD) == [GOOD]


@pytest.mark.parametrize(
    ("place", "code", "value", "counter"),
    [
        (4, "I", 3, "unknown_message"), (4, "I", 2**32 - 1, "unknown_message"),
        (8, "I", 2**32 - 1, "overlong_record"), (8, "I", LIMIT + 1, "overlong_record"),
        (8, "I", 0, "short_record"), (8, "I", 191, "short_record"), (8, "I", 192, "bad_ping"),
        (8, "I", len(GOOD) - 1, "bad_ping"), (8, "I", len(GOOD) + 1, "bad_checksum"),
        (20, "I", 1, "bad_checksum"),
        (32, "I", 0, "bad_ping"), (32, "I", 2**32 - 1, "bad_ping"), (32, "I", 4097, "bad_ping"),
        (36, "I", 0, "bad_ping"), (36, "I", 2**32 - 1, "bad_ping"), (48, "I", 7, "bad_ping"),
        (24, "f", float("nan"), "bad_ping"), (28, "f", float("inf"), "bad_ping"),
    ],
)  # fmt: skip
def test_absurd_numbers_cost_their_packet_and_no_other(place: int, code: str, value: float, counter: str) -> None:
    data = bytearray(GOOD)
    struct.pack_into(f"<{code}", data, place, value)
    framer = Framer(LIMIT)
    assert found(framer, bytes(data) + NEXT) == [NEXT]
    assert framer.counters == {counter: 1, "garbage_bytes": len(data), "records": 1}


def test_without_a_checksum_a_packet_cut_off_never_takes_the_next_ones_bytes() -> None:
    following = wire.image(wire.samples(4), number=4, checksum=0)
    framer = Framer(LIMIT)
    assert found(framer, UNCHECKED[:-20] + following) == [following]
    assert framer.counters == {"nested_record": 1, "garbage_bytes": len(UNCHECKED) - 20, "records": 1}


def test_packets_that_firmware_fills_up_to_one_size_are_taken() -> None:
    filled = wire.image(wire.samples(1), padding=5000)
    assert found(Framer(LIMIT), filled + NEXT) == [filled, NEXT]


def test_other_versions_and_unknown_sample_types_are_no_reason_to_lose_the_stream() -> None:
    other = wire.image(wire.samples(1), version=5)
    strange = wire.image(wire.samples(1), number_type=99)
    assert found(Framer(LIMIT), other + strange + NEXT) == [other, strange, NEXT]


@pytest.mark.parametrize("chunk", [1, 7, 4096, 10**6])
def test_preambles_alone_are_passed_over_at_once_and_all_counted(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at = []

    def counted(data: Buffer, at: int, most: int) -> str | None:
        looked_at.append(at)
        return fault_of(data, at, most)

    monkeypatch.setattr(framer_module, "fault_of", counted)
    framer, stream = Framer(LIMIT), PREAMBLE * 2000 + GOOD
    came = [packet.data for at in range(0, len(stream), chunk) for packet in framer.feed(stream[at : at + chunk])]
    assert came == [GOOD]
    assert framer.counters == {"unknown_message": 2000, "garbage_bytes": 8000, "records": 1}
    assert chunk < 10**6 or len(looked_at) < 10


def test_a_claim_of_the_longest_size_holds_no_more_than_that() -> None:
    counters: Counter[str] = Counter()
    framer = Framer(LIMIT, counters)
    framer.feed(wire.sealed(bytes(LIMIT - 24), 1, checksum=1)[:24])
    for _ in range(200):
        framer.feed(bytes(1000))
        assert framer.missing_bytes <= LIMIT
    assert counters["bad_checksum"] == 1
    assert counters["garbage_bytes"] >= 200_000 - LIMIT


def test_headers_within_headers_cost_few_checksums_and_the_next_packet_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    checked = 0
    sound = packets.is_sound

    def counting(data: memoryview, header: Header) -> bool:
        nonlocal checked
        checked += header.size
        return sound(data, header)

    monkeypatch.setattr(packets, "is_sound", counting)
    hostile = struct.pack("<4s3I4xI", PREAMBLE, 1, LIMIT - 1, 1, 7) * 4000
    framer = Framer(LIMIT)
    fed = 0
    for at in range(0, len(hostile), 4096):
        part = hostile[at : at + 4096]
        assert framer.feed(part) == []
        fed += len(part)
        assert checked <= sync_framer.CHECKED_AGAIN * fed + LIMIT
    assert framer.feed(bytes(2 * LIMIT)) == []
    assert [packet.data for packet in framer.feed(GOOD)] == [GOOD]
