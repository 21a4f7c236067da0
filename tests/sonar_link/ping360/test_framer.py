"""Messages in a byte stream: any chunking, any damage; nothing raises, every byte is accounted for."""

import pytest
from hypothesis import given, strategies as st

from ods.sonar_link import sync_framer
from ods.sonar_link.ping360 import messages
from ods.sonar_link.ping360.framer import Framer
from ods.sonar_link.sync_framer import MAX_PACKET_BYTES
from tests.sonar_link.ping360 import wire

GOOD = wire.auto_data(17)
NEXT = wire.device_data(18)
REFUSAL = wire.nack(2602)


def found(framer: Framer, stream: bytes) -> list[bytes]:
    return [packet.data for packet in framer.feed(stream) + framer.flush()]


def test_messages_of_all_kinds_and_arrivals() -> None:
    framer = Framer()
    assert framer.feed(GOOD[:50], 5) == []
    assert framer.waiting_since_ns == 5
    assert framer.missing_bytes == len(GOOD) - 50
    first, second, third = framer.feed(GOOD[50:] + NEXT + REFUSAL, 7)
    assert [first.data, second.data, third.data] == [GOOD, NEXT, REFUSAL]
    assert (first.first_ns, first.last_ns, second.first_ns) == (5, 7, 7)
    assert (first.header.kind, second.header.kind, third.header.kind) == (2301, 2300, 2)
    assert +framer.counters == {"records": 3}


PARTS = [GOOD, NEXT, REFUSAL, b"BR", b"B", b"noise", GOOD[:150], wire.auto_data(3, b"BRBR" * 9)]


@given(st.lists(st.sampled_from(PARTS)), st.data())
def test_the_chunking_never_matters(parts: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(parts)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)))))
    whole, cut = Framer(), Framer()
    expected = found(whole, stream)
    came = [
        packet.data for begin, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)
        for packet in cut.feed(stream[begin:end])
    ] + [packet.data for packet in cut.flush()]  # fmt: skip
    assert came == expected
    assert cut.counters == whole.counters
    assert sum(map(len, came)) + cut.counters["garbage_bytes"] == len(stream)


@given(st.integers(0, len(GOOD) * 8 - 1))
def test_a_flipped_bit_never_becomes_a_beam(bit: int) -> None:
    spoilt = bytearray(GOOD)
    spoilt[bit // 8] ^= 1 << bit % 8
    assert found(Framer(), bytes(spoilt) + NEXT) == [NEXT]


@given(st.integers(0, len(GOOD) - 1), st.sampled_from([NEXT, REFUSAL]))
def test_a_message_that_is_cut_costs_no_other(cut: int, following: bytes) -> None:
    framer = Framer()
    assert found(framer, GOOD[:cut] + following) == [following]
    assert framer.counters["garbage_bytes"] == cut


@given(st.binary(max_size=3000))
def test_random_bytes_raise_nothing_and_are_accounted_for(stream: bytes) -> None:
    framer = Framer()
    came = found(framer, stream)
    assert sum(map(len, came)) + framer.counters["garbage_bytes"] == len(stream)


@pytest.mark.parametrize(
    ("header", "counter"),
    [
        (b"BR" + wire.u16(messages.MOST_BYTES + 1, 2301), "overlong_record"),
        (b"BR" + wire.u16(19, 2301), "short_record"),
        (b"BR" + wire.u16(1, 2), "short_record"),
        (b"BR" + wire.u16(60000, 3), "overlong_record"),
        (b"BR" + wire.u16(10, 1300), "unknown_message"),
    ],
)
def test_what_no_ping360_sends_is_not_waited_for(header: bytes, counter: str) -> None:
    framer = Framer()
    assert [packet.data for packet in framer.feed(header + bytes(2) + GOOD)] == [GOOD]
    assert framer.counters[counter] == 1


def test_headers_within_headers_cost_few_checksums(monkeypatch: pytest.MonkeyPatch) -> None:
    summed = 0
    is_sound = messages.is_sound

    def counting(message: memoryview) -> bool:
        nonlocal summed
        summed += len(message)
        return is_sound(message)

    monkeypatch.setattr(messages, "is_sound", counting)
    header = b"BR" + wire.u16(messages.MOST_BYTES, 2301) + bytes(2)
    stream = header * 4000
    framer = Framer()
    for begin in range(0, len(stream), 1000):
        framer.feed(stream[begin : begin + 1000])
    assert summed <= sync_framer.CHECKED_AGAIN * len(stream) + messages.MOST_BYTES
    assert messages.MOST_BYTES < MAX_PACKET_BYTES
