"""The s7k stream as a protocol: when pings were transmitted, what is sent, what is told; pure, with made-up time."""

from collections import Counter

import numpy as np
import pytest

from ods.messages import Ping
from ods.sonar_link.s7k import records, remote_control
from ods.sonar_link.s7k.drf import DeviceId, encode_record
from ods.sonar_link.s7k.framer import RecordFramer
from ods.sonar_link.s7k.network_frame import Deframer, frame_record
from ods.sonar_link.s7k.protocol import S7kProtocol
from ods.sonar_link.setting_requests import Controls
from ods.sonar_link.settings import SonarSettings
from tests.sonar_link.sonar_samples import UTC_NS, make_ping

S = 1_000_000_000
MS = 1_000_000
HOUR_NS = 3600 * S
LISTENED_NS = round(2 * (0.5 + 39 * 0.25) / 1500.0 * 1e9)
"""Of `make_ping`."""


def protocol(port: str = "/dev/seabat", latency_ms: float = 0.0, range_m: float | None = None) -> S7kProtocol:
    settings = SonarSettings(port=port, latency_ms=latency_ms, range_m=range_m)
    return S7kProtocol(settings, Counter(), utc_of=lambda t_ns: UTC_NS + t_ns)


def feed(made: S7kProtocol, ping: Ping, arrival_ns: int, device: int = 7000) -> Ping:
    (back,) = made.feed(records.encode_ping(ping, DeviceId(device)), arrival_ns)
    return back


def test_transmission_is_when_the_record_left_less_listening_and_latency() -> None:
    """10 m at 1500 m/s: the last echo comes 13.33 ms after transmission."""
    made = protocol(latency_ms=2.0)
    for number in range(4):
        ping = make_ping(number, range0_m=0.25, dr_m=0.25, samples=40, utc_ns=UTC_NS + number * 150 * MS)
        late_ns = 20 * MS if number == 3 else 0  # then the sonar's own time says when it was
        arrival_ns = 5 * S + number * 150 * MS + late_ns
        back = feed(made, ping, arrival_ns)
        assert back.t_ns == pytest.approx(arrival_ns - late_ns - 13_333_333 - 2 * MS, abs=20_000 * number)
        assert back.t_rx_ns == arrival_ns


def test_two_sonars_on_a_line_are_reported_while_both_ping() -> None:
    """One has the configured mounting, of the other objects would lie elsewhere in lists that are valid."""
    made = protocol()
    for number in range(20):
        feed(made, make_ping(number), number * 150 * MS)
        assert made.problems(number * 150 * MS) == []
    feed(made, make_ping(3), 3000 * MS, device=7125)
    told = ["2 sonars ping on this line (devices 7000:0, 7125:0): leave one on"]
    assert made.problems(3000 * MS) == made.problems(7800 * MS) == told
    assert made.problems(8001 * MS) == []


def test_transmission_times_follow_the_device_through_a_jittery_line() -> None:
    """The line holds records back by 3 ms on the average, now and then by 15; the device's clock is an hour wrong."""
    rng = np.random.default_rng(5)
    made = protocol(latency_ms=2.0)
    error_ns = []
    for number in range(200):
        transmit_ns = 50 * S + 150 * MS * number
        ping = make_ping(number, utc_ns=UTC_NS + HOUR_NS + transmit_ns)
        arrival_ns = transmit_ns + LISTENED_NS + 2 * MS + int(rng.exponential(3e6))
        error_ns.append(feed(made, ping, arrival_ns).t_ns - transmit_ns)
    assert max(map(abs, error_ns[64:])) < 2 * MS


def test_a_line_that_falls_behind_by_two_seconds_for_good_leaves_pings_their_time() -> None:
    made = protocol()
    for number in range(80):
        transmit_ns = 50 * S + 150 * MS * number
        late_ns = 2 * S if number >= 40 else 0
        back = feed(made, make_ping(number, utc_ns=UTC_NS + transmit_ns), transmit_ns + LISTENED_NS + late_ns)
        assert back.t_ns == pytest.approx(transmit_ns, abs=1 * MS)
    assert (made.counters["device_clock_jumps"], made.counters["pings_held_back"]) == (0, 40)


def test_each_sonar_has_its_own_clock() -> None:
    made = protocol()
    for number in range(40):
        transmit_ns = 50 * S + 150 * MS * number
        device = 1 + number % 2
        ping = make_ping(number, utc_ns=UTC_NS + device * HOUR_NS + transmit_ns)
        back = feed(made, ping, transmit_ns + LISTENED_NS, device)
        assert back.t_ns == pytest.approx(transmit_ns, abs=20_000)
    assert made.counters["device_clock_jumps"] == made.counters["wild_device_times"] == 0


def test_a_sonar_without_a_clock_is_timed_by_its_bytes() -> None:
    made = protocol(latency_ms=2.0)
    ping = feed(made, make_ping(1, utc_ns=UTC_NS), S)
    timeless = bytearray()
    for frame in records.ping_records(make_ping(2)):
        without = bytearray(frame)
        without[20:30] = bytes(10)
        without[-4:] = (sum(without[:-4]) & 0xFFFFFFFF).to_bytes(4, "little")
        timeless += without
    (back,) = made.feed(bytes(timeless), 3 * S)
    assert back.t_ns == 3 * S - LISTENED_NS - 2 * MS
    assert (ping.seq, back.seq, made.counters["no_device_time"]) == (0, 1, 1)


def test_over_tcp_everything_travels_in_network_frames_and_a_connection_begins_with_a_subscription() -> None:
    made = protocol("tcp://10.0.0.5:7000", range_m=50.0)
    made.connected(0)
    stream = b"".join(made.requests(0))
    sent = RecordFramer().feed(Deframer(1 << 20).feed(stream))
    subscription, wanted_range = map(remote_control.decode_request, sent)
    assert remote_control.subscribed_types(subscription) == {7000, 7004, 7042}
    assert (wanted_range.command, remote_control.value_of(wanted_range)) == (remote_control.SET_RANGE, 50.0)
    assert {record.time_ns for record in sent} == {UTC_NS}
    assert made.requests(S) == []
    framed = frame_record(records.encode_ping(make_ping(1)), 1)
    assert len(made.feed(framed[:100], S) + made.feed(framed[100:], S)) == 1
    assert made.counters["network_frames"] == 1


def test_requests_go_to_the_sonar_that_was_received_and_its_settings_are_decoded_once() -> None:
    made = protocol(range_m=50.0)
    feed(made, make_ping(1), S, device=7128)
    assert made.setting_requests.reported == Controls(10.5, 0.0, 0.0)
    made.connected(S)
    (request,) = RecordFramer().feed(b"".join(made.requests(S)))
    assert (request.record_type, request.device) == (7500, DeviceId(7128))


def test_a_reply_that_cannot_be_read_is_counted_and_is_no_other_record() -> None:
    made = protocol()
    assert made.feed(encode_record(remote_control.REFUSED, b"short", UTC_NS, records.DEVICE), 0) == []
    assert made.counters == Counter(records=1, bad_remote_control=1)


def test_a_record_that_does_not_end_is_given_up_after_its_time() -> None:
    made = protocol()
    settings, geometry, samples = records.ping_records(make_ping(1))
    made.feed(settings + geometry + samples[:100], 0)
    assert made.missing_bytes == len(samples) - 100
    assert made.check(S) == []
    assert made.missing_bytes > 0
    assert made.check(S + 1) == []
    assert (made.missing_bytes, made.counters["truncated_record"]) == (0, 1)


def test_a_stream_that_ends_gives_what_was_whole_in_it() -> None:
    made = protocol()
    false_header = records.ping_records(make_ping(9, samples=4000))[2][:70]
    made.feed(false_header + records.encode_ping(make_ping(1)), 0)
    assert [ping.ping_number for ping in made.end_stream(0)] == [1]
    assert made.missing_bytes == 0
