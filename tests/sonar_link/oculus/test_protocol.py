"""The protocol behind the seam: bytes to pings on our clock, what it asks, what it says."""

import struct
from collections import Counter
from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.messages import Ping, SonarRequest, frame_of
from ods.sonar_link.files.opening import open_pings
from ods.sonar_link.oculus.protocol import OculusProtocol
from ods.sonar_link.planner_requests import PlannerRequests
from ods.sonar_link.settings import SonarSettings
from tests.recordings import OCULUS
from tests.sonar_link.oculus import wire

MS = 1_000_000
S = 1_000_000_000
PORT = "tcp://192.168.2.3:52100"
DUMMY = bytes(wire.header(0xFF, 16))


def make(**settings: Any) -> OculusProtocol:
    """A protocol that has its connection since 0 s."""
    table: dict[str, Any] = {"port": PORT, "protocol": "oculus", **settings}
    protocol = OculusProtocol(msgspec.convert(table, SonarSettings), Counter())
    protocol.check(0)
    protocol.connected(0)
    return protocol


def feed(protocol: OculusProtocol, messages: Sequence[bytes], period_ns: int = S // 10) -> list[Ping]:
    return [ping for turn, data in enumerate(messages) for ping in protocol.feed(data, S + turn * period_ns)]


def test_the_real_recording_live_and_from_its_file() -> None:
    protocol = make()
    data = OCULUS.read_bytes()
    live = [ping for at in range(0, len(data), 65536) for ping in protocol.feed(data[at : at + 65536], S)]
    recorded = open_pings(OCULUS).pings
    assert len(live) == 3
    for came, read in zip(live, recorded, strict=True):
        assert came.setting == "mode 2, gain 50 %, gamma 127"
        times = {"t_ns": 0, "t_rx_ns": 0, "utc_ns": 0, "setting": ""}
        assert msgspec.structs.replace(came, **times) == msgspec.structs.replace(read, **times)
    assert +protocol.counters == {"records": 3, "pings": 3, "no_device_time": 3}


@pytest.mark.parametrize("chunk", [1, 13, 1000])
def test_any_chunking_gives_the_same_pings(chunk: int) -> None:
    stream = b"noise" + b"".join(wire.ping(wire.image(n), 1 + n % 2, number=n) for n in range(1, 6)) + DUMMY
    whole, cut = make(), make()
    expected = whole.feed(stream, S)
    came = [ping for at in range(0, len(stream), chunk) for ping in cut.feed(stream[at : at + chunk], S)]
    assert [ping.ping_number for ping in expected] == [1, 2, 3, 4, 5]
    assert came == expected
    assert cut.counters == whole.counters


def test_transmission_is_reported_by_the_sonars_clock_not_by_late_arrivals() -> None:
    protocol = make(latency_ms=2.0)
    listening_ns = round(2 * (0.025 + 4 * 0.05) / 1500 * S) + 2 * MS
    late_ms = [0, 0, 0, 7, 3, 9, 0, 5]
    pings = []
    for turn, late in enumerate(late_ms):
        sent_ns = S + turn * 100 * MS
        data = wire.ping(wire.image(1), number=turn + 1, start=500.0 + 0.1 * turn)
        pings += protocol.feed(data, sent_ns + listening_ns + late * MS)
    errors_ms = [(ping.t_ns - S - turn * 100 * MS) / MS for turn, ping in enumerate(pings)]
    assert errors_ms[3:] == pytest.approx([0.0] * 5, abs=0.1)
    assert protocol.counters["no_device_time"] == 0


@pytest.mark.parametrize(("version", "start"), [(1, 100.0), (2, 0.0), (2, float("nan")), (2, -5.0), (2, 1e300)])
def test_without_a_time_of_its_own_a_ping_is_stamped_by_its_arrival(version: int, start: float) -> None:
    protocol = make()
    (ping,) = protocol.feed(wire.ping(wire.image(1), version, start=start), S)
    assert ping.t_ns == S - round(2 * 0.225 / 1500 * S)
    assert protocol.counters["no_device_time"] == 1


def test_a_sonar_that_was_switched_off_and_on_has_a_new_clock_and_new_numbers() -> None:
    protocol = make()
    feed(protocol, [wire.ping(wire.image(n), number=9000 + n, start=500 + n / 10) for n in range(10)])
    protocol.end_stream(3 * S)
    protocol.connected(60 * S)
    pings = [
        ping for n in range(8)
        for ping in protocol.feed(wire.ping(wire.image(n), number=n, start=5 + n / 10), 60 * S + n * 100 * MS)
    ]  # fmt: skip
    assert [ping.ping_number for ping in pings] == list(range(8))
    assert all(abs(ping.t_ns - 60 * S - n * 100 * MS) < 2 * MS for n, ping in enumerate(pings))
    assert protocol.counters["ping_number_restarts"] == 1


def test_gaps_doubles_and_others_are_counted() -> None:
    protocol = make()
    numbers = [1, 2, 2, 5, 6]
    feed(protocol, [*(wire.ping(wire.image(n), number=n) for n in numbers), DUMMY, bytes(wire.header(0x80, 50))])
    counted = {name: protocol.counters[name] for name in ("pings", "duplicate_pings", "lost_pings", "other_records")}
    assert counted == {"pings": 4, "duplicate_pings": 1, "lost_pings": 2, "other_records": 2}


@pytest.mark.parametrize(
    ("change", "counter"),
    [
        ({"bearings": [0] * 8}, "bad_ping"),
        ({"bearings": [30000, *range(1, 8)]}, "bad_ping"),
        ({"dr": 0.0}, "bad_ping"),
        ({"dr": -1.0}, "bad_ping"),
        ({"dr": float("nan")}, "bad_ping"),
        ({"sound": 0.0}, "bad_ping"),
        ({"sound": float("inf")}, "bad_ping"),
    ],
)
def test_numbers_that_cannot_be_cost_their_ping_only(change: dict[str, Any], counter: str) -> None:
    protocol = make()
    (ping,) = feed(protocol, [wire.ping(wire.image(1), **change), wire.ping(wire.image(2), number=2)])
    assert ping.ping_number == 2
    assert protocol.counters[counter] == 1


def test_24_bit_samples_are_counted_as_a_layout_that_is_not_known() -> None:
    protocol = make()
    data = bytearray(wire.ping(np.zeros((5, 24), np.uint8)))
    data[161] = 2
    struct.pack_into("<H", data, 172, 8)
    assert protocol.feed(bytes(data), S) == []
    assert protocol.counters["unsupported_layout"] == 1


@given(st.lists(st.tuples(st.integers(0, 700), st.integers(0, 255)), max_size=40), st.binary(max_size=200))
def test_wrong_bytes_never_raise_and_the_next_ping_comes(changes: list[tuple[int, int]], noise: bytes) -> None:
    protocol = make()
    spoilt = bytearray(wire.ping(wire.image(1)) + noise + wire.ping(wire.image(2), 1, number=2) + wire.status())
    for at, value in changes:
        spoilt[at % len(spoilt)] = value
    protocol.feed(bytes(spoilt), S)
    protocol.check(5 * S)
    protocol.end_stream(5 * S)
    protocol.connected(6 * S)
    pings = protocol.feed(wire.ping(wire.image(3), number=77777), 6 * S)
    assert [ping.ping_number for ping in pings] == [77777]
    np.testing.assert_array_equal(frame_of(pings[0]), wire.image(3).T)
    for text in [*protocol.problems(7 * S), protocol.traffic(1.0), protocol.diagnosis(1.0)]:
        assert isinstance(text, str)


def test_a_result_that_stops_is_given_up_after_the_timeout() -> None:
    protocol = make(record_timeout_s=0.5)
    assert protocol.feed(wire.ping(wire.image(1))[:-1], S) == []
    assert protocol.missing_bytes == 1
    protocol.check(S + 500 * MS)
    assert protocol.counters["truncated_record"] == 0
    protocol.check(S + 500 * MS + 1)
    assert protocol.counters["truncated_record"] == 1


def test_settings_that_are_not_taken_standby_and_heat_are_problems_in_plain_words() -> None:
    protocol = make(oculus={"range_m": 20.0, "settle_s": 1.0})
    protocol.received(wire.status(state=3 | 1 << 14), "192.168.2.3", S)
    protocol.feed(wire.ping(wire.image(1), gamma=127, range=10.0, salinity=35.0), 2 * S)
    protocol.feed(DUMMY, 2 * S)
    assert protocol.problems(3 * S) == [
        "the sonar is hot: is it in the water?",
        "the sonar is in standby",
        "the sonar did not accept range 20 m: it reports 10 m",
    ]


def test_a_sonar_that_cannot_be_reached_is_reported_of_by_its_status() -> None:
    protocol = make()
    protocol.end_stream(S)
    assert protocol.problems(3 * S) == []
    assert protocol.problems(4 * S) == ["no status of any sonar is received: is it on, and is the cable connected?"]
    protocol.received(wire.status(client="192.168.2.50"), "192.168.2.3", 8 * S)
    assert protocol.problems(9 * S) == ["it reports that 192.168.2.50 has its connection"]
    assert make(oculus={"status_port": 0}).side_port is None


def test_planners_cannot_set_it() -> None:
    protocol = make()
    answers: list[Any] = []
    planners = PlannerRequests(protocol.setting_requests, 4.0, lambda _, answer: answers.append(answer))
    planners.take([b"peer"], SonarRequest(range_m=10.0), S)
    assert not answers[0].ok
    assert "range" in answers[0].reason
    protocol.feed(wire.ping(wire.image(1), range=25.0), S)
    planners.take([b"peer"], SonarRequest(), S)
    assert (answers[1].ok, answers[1].range_m, answers[1].gain_db) == (True, 25.0, None)


def test_what_the_doctor_says() -> None:
    protocol = make()
    assert protocol.traffic(10.0) == ""
    assert "no status of any sonar" in protocol.diagnosis(10.0)
    protocol.feed(DUMMY, S)
    assert "in standby" in protocol.diagnosis(10.0)
    protocol.feed(bytes(wire.header(0x22, 400)), S)
    assert "another program" in protocol.diagnosis(10.0)
    protocol.received(wire.status(), "192.168.2.3", 2 * S)
    feed(protocol, [wire.ping(wire.image(n), number=n) for n in range(1, 6)])
    assert protocol.traffic(0.5) == (
        "full ping results at 2.0 Hz, ping results at 10.0 Hz, dummies at 2.0 Hz "
        "from M750d number 7892 at 192.168.2.3, 32 deg C at its warmest"
    )


@pytest.mark.parametrize(
    ("settings", "word"),
    [({"port": "/dev/ttyUSB0"}, "tcp"), ({"range_m": 20.0}, "range_m"), ({"gain_db": 3.0}, "docs/sonars/oculus.md")],
)
def test_settings_of_another_kind_of_sonar_are_refused(settings: dict[str, Any], word: str) -> None:
    with pytest.raises(msgspec.ValidationError, match=word):
        make(**settings)
