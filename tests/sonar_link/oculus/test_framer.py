"""Any bytes in any chunks: the same messages, nothing raised, memory bounded, every loss counted."""

import struct
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.sonar_link.oculus import framer as framer_module
from ods.sonar_link.oculus.framer import Framer, fault_of
from ods.sonar_link.oculus.messages import CHECK_WORD, Buffer, MessageKind
from tests.sonar_link.oculus import wire

GOOD = wire.ping(wire.image(1), number=1)
NEXT = wire.ping(wire.image(2), 1, number=2)
DUMMY = bytes(wire.header(0xFF, 16))
LIMIT = 100_000


def numbers(framer: Framer, data: bytes, chunk: int = 0) -> list[tuple[int, int]]:
    """MessageKind and size of what comes out."""
    chunks = [data[at : at + chunk] for at in range(0, len(data), chunk)] if chunk else [data]
    found = [message for part in chunks for message in framer.feed(part)] + framer.flush()
    return [(message.header.kind, message.header.size) for message in found]


@pytest.mark.parametrize("chunk", [1, 2, 7, 200, 0])
def test_messages_come_out_whole_in_any_chunking(chunk: int) -> None:
    framer = Framer(LIMIT)
    found = numbers(framer, GOOD + DUMMY + NEXT, chunk)
    assert found == [(MessageKind.PING, len(GOOD)), (MessageKind.DUMMY, 16), (MessageKind.PING, len(NEXT))]
    assert +framer.counters == {"records": 3}


def test_arrivals_of_the_first_and_the_last_byte() -> None:
    framer = Framer(LIMIT)
    assert framer.feed(DUMMY + GOOD[:10], 5) != []
    assert framer.waiting_since_ns == 5
    framer.feed(GOOD[10:100], 6)
    assert framer.missing_bytes == len(GOOD) - 100
    (message,) = framer.feed(GOOD[100:] + b"S", 7)
    assert (message.first_ns, message.last_ns, message.data) == (5, 7, GOOD)


@given(st.lists(st.sampled_from([GOOD, NEXT, DUMMY, b"S", b"SO", b"noise", GOOD[:130], GOOD[:-9]])), st.data())
def test_the_chunking_never_matters(parts: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(parts)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)))))
    whole, cut = Framer(LIMIT), Framer(LIMIT)
    expected = whole.feed(stream) + whole.flush()
    found = [
        message for begin, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)
        for message in cut.feed(stream[begin:end])
    ] + cut.flush()  # fmt: skip
    assert [message.data for message in found] == [message.data for message in expected]
    assert cut.counters == whole.counters


@given(st.binary(max_size=4000))
def test_random_bytes_never_raise_and_nothing_is_kept(noise: bytes) -> None:
    framer = Framer(LIMIT)
    framer.feed(b"SO" + noise)
    framer.flush()
    assert framer.missing_bytes == 0
    assert framer.counters["garbage_bytes"] <= len(noise) + 2
    assert [message.data for message in framer.feed(GOOD)] == [GOOD]


@given(st.lists(st.tuples(st.integers(0, 3 * len(GOOD) - 1), st.integers(0, 255)), max_size=30))
def test_wrong_bytes_never_raise_and_later_messages_come(changes: list[tuple[int, int]]) -> None:
    spoilt = bytearray(3 * GOOD)
    for at, value in changes:
        spoilt[at] = value
    framer = Framer(LIMIT)
    framer.feed(bytes(spoilt))
    framer.flush()
    assert [message.data for message in framer.feed(NEXT)] == [NEXT]


@pytest.mark.parametrize("chunk", [1, 7, 4096, 10**6])
def test_sync_words_alone_are_passed_over_at_once_and_all_counted(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at = []

    def counted(data: Buffer, at: int, most: int) -> str | None:
        looked_at.append(at)
        return fault_of(data, at, most)

    monkeypatch.setattr(framer_module, "fault_of", counted)
    framer, stream = Framer(LIMIT), CHECK_WORD * 2000 + GOOD
    found = [message.data for at in range(0, len(stream), chunk) for message in framer.feed(stream[at : at + chunk])]
    assert found == [GOOD]
    assert framer.counters == {"unknown_message": 2000, "garbage_bytes": 4000, "records": 1}
    assert chunk < 10**6 or len(looked_at) < 10


def test_a_header_of_4_gb_costs_nothing() -> None:
    data = bytearray(GOOD)
    struct.pack_into("<I", data, 10, 2**32 - 1)
    framer = Framer(LIMIT)
    assert numbers(framer, bytes(data) + NEXT) == [(MessageKind.PING, len(NEXT))]
    assert framer.counters == {"overlong_record": 1, "garbage_bytes": len(data), "records": 1}


@pytest.mark.parametrize(
    ("place", "code", "value"),
    [
        (170, "H", 0), (170, "H", 65535), (172, "H", 0), (172, "H", 65535), (172, "H", 7),  # lines, beams
        (190, "I", 2**32 - 1), (190, "I", 0), (190, "I", 203), (194, "I", 2**32 - 1), (194, "I", 41),  # the image
        (161, "B", 7), (162, "d", float("nan")), (145, "d", float("inf")), (97, "d", float("nan")),
        (10, "I", 200), (10, "I", 20),
    ],
)  # fmt: skip
def test_absurd_numbers_cost_their_ping_and_no_other(place: int, code: str, value: float) -> None:
    data = bytearray(GOOD)
    struct.pack_into(f"<{code}", data, place, value)
    framer = Framer(LIMIT)
    assert numbers(framer, bytes(data) + NEXT) == [(MessageKind.PING, len(NEXT))]
    assert framer.counters["bad_ping"] + framer.counters["short_record"] == 1
    assert framer.counters["garbage_bytes"] == len(data)


def test_a_message_cut_off_never_takes_the_next_ones_bytes() -> None:
    third = wire.ping(wire.image(3), number=3)
    framer = Framer(LIMIT)
    assert numbers(framer, GOOD[:-20] + third) == [(MessageKind.PING, len(third))]
    assert framer.counters == {"nested_record": 1, "garbage_bytes": len(GOOD) - 20, "records": 1}


def test_a_message_that_does_not_end_is_given_up() -> None:
    framer = Framer(LIMIT)
    assert framer.feed(GOOD[:-20]) == []
    assert framer.give_up() == []
    assert [message.data for message in framer.feed(NEXT)] == [NEXT]
    assert framer.counters["truncated_record"] == 1


def test_a_claim_of_the_longest_size_holds_no_more_than_that() -> None:
    framer = Framer(LIMIT)
    head = bytes(wire.header(MessageKind.FULL_PING, LIMIT))[:16]
    framer.feed(head)
    for _ in range(200):
        framer.feed(bytes(1000))
        assert framer.missing_bytes <= LIMIT
    assert framer.counters["records"] == 1
    assert framer.counters["garbage_bytes"] >= 200_000 + 16 - LIMIT - 1


def test_a_megabyte_of_sync_words_ends() -> None:
    counters: Counter[str] = Counter()
    framer = Framer(LIMIT, counters)
    assert framer.feed(b"SO" * 20_000) == []
    assert framer.feed(np.random.default_rng(0).bytes(200_000)) == []
    framer.flush()
    assert counters["garbage_bytes"] == 240_000
