"""The protocol by itself: what is asked, what pings say, what is said when none comes."""

import math
from collections import Counter

import numpy as np
import pytest

from ods.base.clock import NS
from ods.messages import Ping, frame_of
from ods.sonar_link.ping360 import messages
from ods.sonar_link.ping360.messages import Kind, Sweep
from ods.sonar_link.ping360.protocol import Ping360Protocol
from ods.sonar_link.ping360.settings import Ping360Settings
from ods.sonar_link.settings import SonarSettings
from tests.sonar_link.ping360 import wire

OWN = Ping360Settings(range_m=4.5, sector_deg=90.0, samples=200, sound_speed=1500.0)
WANTED = OWN.transmission
LISTENING_NS = round(200 * WANTED.period * 25)


def made(port: str = "/dev/ttyUSB0") -> tuple[Ping360Protocol, "Counter[str]"]:
    counters: Counter[str] = Counter()
    return Ping360Protocol(SonarSettings(port, protocol="ping360", ping360=OWN, latency_ms=3.0), counters), counters


def obeyed(angle: int, samples: bytes = bytes(200)) -> bytes:
    """Return a beam as it was asked for."""
    return messages.encode_beam(
        messages.Beam(
            WANTED.gain, angle % 400, WANTED.pulse_us, WANTED.period, WANTED.frequency_khz, OWN.sweep, samples
        )
    )


def test_what_is_asked_for() -> None:
    assert OWN.sweep == Sweep(start=350, stop=50, steps=1)
    assert Ping360Settings(sector_deg=360.0).sweep[:2] == (200, 199)
    assert Ping360Settings(sector_deg=120.0, steps=4).sweep[:3] == (332, 68, 4)
    assert WANTED.period * 25e-9 * 200 * 1500.0 / 2 == pytest.approx(4.5, rel=0.01)
    near = Ping360Settings(range_m=1.0).transmission
    assert near.period >= 80
    assert near.period * near.samples * 25e-9 * 750.0 == pytest.approx(1.0, rel=0.02)
    protocol, _ = made()
    protocol.connected(0)
    who, sweep = protocol.requests(0)
    assert messages.decode_id(who) == Kind.DEVICE_INFORMATION
    assert sweep == messages.auto_transmit(WANTED, OWN.sweep)
    assert protocol.requests(3 * NS) == []  # the head may have to turn first
    assert protocol.requests(4 * NS) == [sweep]


def test_beams_make_pings_with_their_own_times() -> None:
    protocol, counters = made()
    protocol.connected(0)
    pings: list[Ping] = []
    for number in range(24):
        row = bytes([number] * 200)
        pings += protocol.feed(obeyed(number - 50, row), NS + number * 80_000_000)
    first = pings[0]
    assert first.beams == 11
    assert first.bearing_rad[0] == pytest.approx(math.radians(-45.0))
    assert first.beam_t_ns[0] == NS - LISTENING_NS - 3_000_000
    assert np.diff(first.beam_t_ns).tolist() == [80_000_000] * 10
    assert first.t_ns == first.beam_t_ns[-1]
    assert first.t_rx_ns == NS + 10 * 80_000_000
    assert frame_of(first)[:, 0].tolist() == list(range(11))
    assert first.range0_m == first.dr_m == pytest.approx(0.0225, rel=0.01)
    assert first.sweep is not None
    assert first.sweep.turn_s == pytest.approx(101 * 0.08)
    assert (counters["beams"], counters["pings"], counters["control_acknowledged"]) == (24, 2, 1)
    assert protocol.requests(NS + 24 * 80_000_000) == []
    (rest,) = protocol.check(6 * NS)
    assert rest.beams == 2
    assert rest.sweep is not None
    assert rest.sweep.ends
    assert protocol.requests(7 * NS)[-1] == messages.auto_transmit(WANTED, OWN.sweep)  # it has fallen silent


def test_another_programs_sweep_is_used_and_said_once_the_sonar_does_not_obey() -> None:
    protocol, counters = made()
    protocol.connected(0)
    for number in range(300):
        now_ns = number * NS // 10
        protocol.requests(now_ns)
        protocol.feed(wire.auto_data(number % 60, sector=(0, 60)), now_ns)
    assert counters["control_requests"] == 3
    assert counters["pings"] > 20
    assert protocol.problems(30 * NS) == ["the sonar sweeps from 0 to 60 gradians, not the requested sector"]
    protocol.feed(obeyed(3), 31 * NS)
    assert protocol.problems(31 * NS) == []


@pytest.mark.parametrize(
    ("stream", "words"),
    [
        (b"", "connected, but no beam: is the sonar on"),
        (b"\xff\x00garbage" * 20, "sonar.baud and wiring"),
        (wire.message(2301, bytes(20), checksum=1), "arrive damaged"),
        (wire.nack(2602), "the sonar refused to sweep by itself (unknown message): its firmware is too old"),
        (wire.nack(2602) + wire.message(4, bytes([2, 1, 1, 2, 3, 0])), "its firmware 1.2.3 is too old"),
        (wire.message(4, bytes([1, 1, 3, 2, 1, 0])), "is not a Ping360 (device type 1)"),
        (wire.message(4, bytes([2, 1, 3, 2, 1, 0])), "can the head turn freely"),
        (wire.auto_data(count=3), "cannot be decoded"),
    ],
)
def test_why_no_beam_comes(stream: bytes, words: str) -> None:
    protocol, _ = made()
    assert protocol.check(0) == []
    protocol.connected(0)
    protocol.feed(stream, 1)
    assert protocol.problems(4 * NS) == []
    (said,) = protocol.problems(6 * NS)
    assert words in said
    assert protocol.diagnosis(5.0) == said


def test_why_there_is_no_line() -> None:
    assert "cannot be opened" in made()[0].diagnosis(5.0)
    assert "is the bridge" in made("udp://192.168.2.2:9092")[0].diagnosis(5.0)


def test_it_is_spoken_over_serial_lines_and_datagrams() -> None:
    assert SonarSettings("udp://192.168.2.2:9092", protocol="ping360")
    with pytest.raises(ValueError, match="works over serial, socket, udp only"):
        SonarSettings("tcp://192.168.2.2:9092", protocol="ping360")
    with pytest.raises(ValueError, match="s7k works over"):
        SonarSettings("udp://192.168.2.2:9092")
    with pytest.raises(ValueError, match="needs an IP address"):
        SonarSettings("udp://blueos:9092", protocol="ping360")
