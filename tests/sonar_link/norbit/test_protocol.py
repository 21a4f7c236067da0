"""The protocol behind the seam: bytes to pings on our clock, what it sends, what it says."""

import struct
from collections import Counter
from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.messages import Ping, frame_of
from ods.sonar_link.norbit.protocol import NorbitProtocol
from ods.sonar_link.settings import SonarSettings
from tests.sonar_link.norbit import wire

MS, S = 1_000_000, 1_000_000_000
PORT = "tcp://192.168.53.68:2211"
GOOD = wire.image(wire.samples(1))


def make(**settings: Any) -> NorbitProtocol:
    """A protocol that has its connection since 0 s."""
    table: dict[str, Any] = {"port": PORT, "protocol": "norbit", **settings}
    protocol = NorbitProtocol(msgspec.convert(table, SonarSettings), Counter())
    protocol.check(0)
    protocol.connected(0)
    return protocol


def feed(protocol: NorbitProtocol, messages: Sequence[bytes], period_ns: int = S // 10) -> list[Ping]:
    return [ping for turn, data in enumerate(messages) for ping in protocol.feed(data, S + turn * period_ns)]


def test_a_packet_is_a_ping() -> None:
    sent = wire.samples(1)
    (ping,) = feed(make(), [wire.image(sent, number=77, first=10, sound=1450.0, rate=14500.0, elevation=-0.1)])
    np.testing.assert_array_equal(frame_of(ping), sent.T)
    assert (ping.beams, ping.samples, ping.dtype, ping.ping_number) == (8, 6, "u2", 77)
    assert ping.dr_m == pytest.approx(0.05)
    assert ping.range0_m == pytest.approx(0.5)  # (10 + 0) c / (2 fs)
    assert ping.sound_speed == 1450.0
    assert ping.frequency_hz == 400e3
    assert ping.bearing_rad == pytest.approx(np.linspace(-1.0, 1.0, 8), rel=1e-6)
    assert ping.elevation_rad == pytest.approx([-0.1] * 8)
    assert ping.setting == "mode 0, 400 kHz, amplitude 15, gain 2, ramp 0 to 40 dB"


@pytest.mark.parametrize(
    ("dtype", "kept"),
    [("u1", "u1"), ("<u2", "u2"), ("<f4", "f4"), ("i1", "u1"), ("<i2", "u2"), ("<u4", "f4"), ("<i4", "f4"),
     ("<u8", "f4"), ("<i8", "f4"), ("<f8", "f4")],
)  # fmt: skip
def test_every_sample_type_of_the_document(dtype: str, kept: str) -> None:
    sent = wire.samples(5, dtype=dtype)
    (ping,) = feed(make(), [wire.image(sent)])
    assert ping.dtype == kept
    np.testing.assert_allclose(frame_of(ping).astype(np.float64), np.maximum(sent, 0).T.astype(np.float64), rtol=1e-6)


def test_beams_that_are_counted_from_starboard_are_turned_round_with_their_samples() -> None:
    sent = wire.samples(2)
    (ping,) = feed(make(), [wire.image(sent, directions=np.linspace(1.0, -0.5, 8).tolist())])
    assert ping.bearing_rad == pytest.approx(np.linspace(-0.5, 1.0, 8), rel=1e-6)
    np.testing.assert_array_equal(frame_of(ping), sent.T[::-1])


def test_samples_from_before_transmission_are_left_out() -> None:
    sent = wire.samples(2)
    (ping,) = feed(make(), [wire.image(sent, first=-2)])
    assert ping.range0_m == 0.0
    np.testing.assert_array_equal(frame_of(ping), sent[2:].T)


@pytest.mark.parametrize("chunk", [1, 13, 1000])
def test_any_chunking_gives_the_same_pings(chunk: int) -> None:
    stream = b"noise" + b"".join(wire.image(wire.samples(n), number=n) for n in range(1, 6)) + wire.sealed(b"1234", 4)
    whole, cut = make(), make()
    expected = whole.feed(stream, S)
    came = [ping for at in range(0, len(stream), chunk) for ping in cut.feed(stream[at : at + chunk], S)]
    assert [ping.ping_number for ping in expected] == [1, 2, 3, 4, 5]
    assert came == expected
    assert cut.counters == whole.counters


def test_transmission_is_reported_by_the_sonars_clock_not_by_late_arrivals() -> None:
    protocol = make(latency_ms=2.0)
    listening_ns = round(2 * (0.5 + 5 * 0.05) / 1500 * S) + 2 * MS
    pings = []
    for turn, late in enumerate([0, 0, 0, 7, 3, 9, 0, 5]):
        data = wire.image(wire.samples(1), number=turn + 1, time=1.7e9 + 0.1 * turn)
        pings += protocol.feed(data, S + turn * 100 * MS + listening_ns + late * MS)
    errors_ms = [(ping.t_ns - S - turn * 100 * MS) / MS for turn, ping in enumerate(pings)]
    assert errors_ms[3:] == pytest.approx([0.0] * 5, abs=0.1)
    assert protocol.counters["no_device_time"] == 0


@pytest.mark.parametrize("time", [0.0, -5.0, float("nan"), 1e300])
def test_without_a_time_of_its_own_a_ping_is_stamped_by_its_arrival(time: float) -> None:
    protocol = make()
    (ping,) = feed(protocol, [wire.image(wire.samples(1), time=time)])
    assert ping.t_ns == S - round(2 * 0.75 / 1500 * S)
    assert protocol.counters["no_device_time"] == 1


def test_gaps_doubles_and_others_are_counted() -> None:
    protocol = make()
    feed(protocol, [*(wire.image(wire.samples(n), number=n) for n in [1, 2, 2, 5, 6]), wire.sealed(bytes(88), 1)])
    counted = {name: protocol.counters[name] for name in ("pings", "duplicate_pings", "lost_pings", "other_records")}
    assert counted == {"pings": 4, "duplicate_pings": 1, "lost_pings": 2, "other_records": 1}


@pytest.mark.parametrize(
    ("change", "counter"),
    [
        ({"directions": [0.0] * 8}, "bad_ping"), ({"directions": [0.0, 2.0, 1.0, *range(3, 8)]}, "bad_ping"),
        ({"directions": [float("nan")] * 8}, "bad_ping"), ({"directions": [float(n) for n in range(8)]}, "bad_ping"),
        ({"rate": 0.0}, "bad_ping"), ({"rate": -1.0}, "bad_ping"), ({"rate": 1e30}, "bad_ping"),
        ({"sound": 0.0}, "bad_ping"), ({"sound": -1500.0}, "bad_ping"), ({"first": 2**31 - 1}, "bad_ping"),
        ({"first": -6}, "bad_ping"), ({"first": -(2**31)}, "bad_ping"), ({"elevation": 2.0}, "bad_ping"),
        ({"number_type": 99}, "unsupported_layout"),
    ],
)  # fmt: skip
def test_numbers_that_cannot_be_cost_their_ping_only(change: dict[str, Any], counter: str) -> None:
    protocol = make()
    (ping,) = feed(protocol, [wire.image(wire.samples(1), **change), wire.image(wire.samples(2), number=2)])
    assert ping.ping_number == 2
    assert protocol.counters[counter] == 1


@given(
    st.lists(st.tuples(st.integers(0, 1000), st.integers(0, 255)), max_size=40),
    st.binary(max_size=200),
    st.booleans(),
)
def test_wrong_bytes_never_raise_and_the_next_ping_comes(
    changes: list[tuple[int, int]], noise: bytes, checked: bool
) -> None:
    protocol = make()
    none = None if checked else 0  # without a checksum wrong numbers come as far as the image
    first = wire.image(wire.samples(1), checksum=none)
    spoilt = bytearray(first + noise + wire.image(wire.samples(2), number=2, checksum=none))
    for at, value in changes:
        spoilt[at % len(spoilt)] = value
    protocol.feed(bytes(spoilt), S)
    protocol.check(5 * S)
    protocol.end_stream(5 * S)
    protocol.connected(6 * S)
    pings = protocol.feed(wire.image(wire.samples(3), number=77777), 6 * S)
    assert [ping.ping_number for ping in pings] == [77777]
    np.testing.assert_array_equal(frame_of(pings[0]), wire.samples(3).T)
    for text in [*protocol.problems(7 * S), protocol.traffic(1.0), protocol.diagnosis(1.0)]:
        assert isinstance(text, str)


@given(st.integers(24, 191), st.binary(min_size=1, max_size=8))
def test_any_header_with_a_right_checksum_is_a_ping_or_counted(at: int, values: bytes) -> None:
    body = bytearray(GOOD[24:])
    body[at - 24 : at - 24 + len(values)] = values
    protocol = make()
    pings = feed(protocol, [wire.sealed(bytes(body)), wire.image(wire.samples(3), number=77777)])
    assert pings[-1].ping_number == 77777
    dropped = ("bad_ping", "unsupported_layout", "duplicate_pings", "nested_record")
    assert len(pings) + sum(protocol.counters[name] for name in dropped) >= 2
    for ping in pings:
        assert np.isfinite([ping.range0_m, ping.dr_m, ping.sound_speed, ping.frequency_hz]).all()


def test_a_packet_that_stops_is_given_up_after_the_timeout() -> None:
    protocol = make(record_timeout_s=0.5)
    assert protocol.feed(GOOD[:-1], S) == []
    assert protocol.missing_bytes == 1
    protocol.check(S + 500 * MS)
    assert protocol.counters["truncated_record"] == 0
    protocol.check(S + 500 * MS + 1)
    assert protocol.counters["truncated_record"] == 1


def answer_all(protocol: NorbitProtocol, now_ns: int, **other: str) -> list[str]:
    """Answer every command as a sonar that obeys, but for `other`; return the commands."""
    protocol.commands_open(now_ns)
    asked = []
    while sent := protocol.requests(now_ns):
        words = sent[0].decode().strip()
        asked.append(words)
        protocol.answered(f"{other.get(words.split()[0], words)} # ok\r\n".encode(), now_ns)
    return asked


def test_why_there_is_no_image_the_likeliest_cause_first() -> None:
    protocol = make()
    assert protocol.problems(5 * S) == []  # its commands take their time
    protocol.commands_lost("192.168.53.68 port 2209: connection refused", S)
    assert protocol.problems(6 * S) == [
        "connected, but no image: it pings only after `set_power 1`, and its command port cannot be reached: "
        "192.168.53.68 port 2209: connection refused"
    ]
    answer_all(protocol, S, set_power="set_power 0")
    assert protocol.problems(6 * S) == ["connected, but no image: the sonar did not accept set_power 1: it reports 0"]
    answer_all(protocol, S)
    assert "Another connected program that does not read stalls all others" in protocol.problems(6 * S)[0]
    unanswered = make()
    unanswered.commands_open(0)
    unanswered.requests(0)
    assert unanswered.diagnosis(1.0) == "connected, but no image: it has not answered any command yet"
    assert "command_port is 0" in make(norbit={"command_port": 0}).diagnosis(1.0)


@pytest.mark.parametrize(
    ("stream", "said"),
    [
        (wire.sealed(bytes(88), 1), "it sends bathymetry, not images: these use sonar.port 2211, images use 2211"),
        (wire.sealed(bytes(168), 4, checksum=0), "it sends snippets, not images"),
        (GOOD[:-1] + b"\xff", "its packets arrive damaged"),
        (
            b"Sonar is ready to accept commands\r\n",
            "the data received are not WBMS packets: is sonar.port 2211 the image port",
        ),
        (wire.image(wire.samples(1), rate=0.0), "its images cannot be decoded: see the counters"),
    ],
)
def test_what_comes_in_place_of_images(stream: bytes, said: str) -> None:
    protocol = make()
    protocol.feed(stream, S)
    assert protocol.diagnosis(1.0).startswith(said)


def test_a_sonar_that_cannot_be_reached() -> None:
    protocol = make()
    protocol.end_stream(S)
    (said,) = protocol.problems(7 * S)
    assert said.startswith("is the sonar on, and is this computer in the network of 192.168.53.68 (`ip route get ")
    protocol.commands_open(7 * S)
    (said,) = protocol.problems(7 * S)
    assert said.startswith("it accepts commands, but no connection at port 2211: images use 2211, or a firewall")


def test_while_pings_come_another_mode_is_a_problem_and_what_it_did_not_take_is_counted() -> None:
    """A problem makes lists not valid; of a range, each ping says itself what it is."""
    protocol = make()
    assert answer_all(protocol, S, set_range="set_range 0 25")[3] == "set_range 0 40"
    protocol.feed(wire.image(wire.samples(1), mode=1), 6 * S)
    assert protocol.counters["control_refused"] == 1
    protocol.commands_lost("refused", 6 * S)
    assert protocol.problems(7 * S) == [
        "the sonar works in mode 1 (bathymetry), not 0 (forward): does another program control it?",
    ]
    assert protocol.traffic(2.0) == "images at 0.5 Hz"


def test_all_commands_are_sent_again_when_the_stream_is_new() -> None:
    protocol = make()
    first = answer_all(protocol, S)
    assert first[-1] == "set_power 1"
    protocol.end_stream(2 * S)
    protocol.connected(3 * S)
    assert protocol.requests(3 * S) == [b"set_mode 0\r\n"]
    protocol.commands_lost("hung up", 3 * S)
    assert protocol.requests(5 * S) == []


def test_the_version_and_the_part_number_are_nobodys_business() -> None:
    """A sonar of another firmware is read as long as its packets fit: bytes 12 to 19 are not looked at."""
    data = bytearray(GOOD)
    struct.pack_into("<II", data, 12, 2**32 - 1, 2**32 - 1)
    assert len(feed(make(), [bytes(data)])) == 1


@pytest.mark.parametrize(
    ("settings", "word"), [({"port": "/dev/ttyUSB0"}, "tcp"), ({"range_m": 20.0}, "docs/sonars/norbit.md")]
)
def test_settings_of_another_kind_of_sonar_are_refused(settings: dict[str, Any], word: str) -> None:
    with pytest.raises(msgspec.ValidationError, match=word):
        make(**settings)
