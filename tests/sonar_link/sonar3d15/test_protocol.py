"""Datagrams to pings: times, losses, and what is said when none comes."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.base.clock import NS
from ods.messages import frame_of
from ods.runtime.counters import COUNTERS
from ods.sonar_link.registry import unsupported_reason
from ods.sonar_link.settings import SonarSettings
from ods.sonar_link.sonar3d15.protocol import Sonar3d15Protocol
from ods.sonar_link.sonar3d15.settings import Sonar3d15Settings
from tests.sonar_link.sonar3d15 import wire

GROUP = "udp://224.0.0.96:4747"
LISTENING_NS = round(2.0 * 15.0 / 1491.0 * NS)


def made(port: str = GROUP, **own: str) -> Sonar3d15Protocol:
    settings = SonarSettings(protocol="sonar3d15", port=port, sonar3d15=Sonar3d15Settings(**own))
    protocol = Sonar3d15Protocol(settings, Counter())
    protocol.connected(0)
    return protocol


def test_each_datagram_is_a_ping_stamped_by_the_sonars_clock() -> None:
    protocol = made()
    late = [0, 3, 1, 2, 0, 5, 1, 0] * 8  # ms on the way
    pings = []
    for number, ms in enumerate(late):
        sent_ns = number * NS // 6
        packet = wire.packet(wire.pixels(number), seq=100 + number, time=(1_700_000_000 + sent_ns // NS, sent_ns % NS))
        pings += protocol.feed(packet, 50 * NS + sent_ns + LISTENING_NS + ms * 1_000_000)
    assert [ping.seq for ping in pings] == list(range(64))
    assert [ping.ping_number for ping in pings] == list(range(100, 164))
    np.testing.assert_allclose(np.diff([ping.t_ns for ping in pings[32:]]), NS / 6, atol=200_000)
    assert pings[0].t_ns == pytest.approx(50 * NS, abs=1_000_000)
    np.testing.assert_array_equal(frame_of(pings[3]), wire.pixels(3).T)
    assert protocol.traffic(2.0) == "range images at 32.0 Hz"


def test_what_is_none_is_counted_and_the_next_datagram_is_read() -> None:
    protocol = made()
    good = wire.packet(wire.pixels(), seq=5)
    flipped = bytearray(good)
    flipped[40] ^= 1
    picture = wire.sealed(wire.literals(wire.message("BitmapImageGreyscale8", b"")))
    unknown = wire.sealed(wire.literals(wire.message("FutureMessage", b"\x08\x01")))
    bad = [b"", b"RIP2", b"RIP3" + bytes(20), good[:-1], good + b"x", bytes(flipped), b"RIP2" + bytes(20)]
    others = [picture, unknown, wire.sealed(b"\x05\x10ab"), wire.packet(wire.pixels(), seq=6, size=(3, 3))]
    for datagram in [*bad, *others, b"RIP2\xff\xff\xff\x7f"]:
        assert protocol.feed(datagram, NS) == []
    assert len(protocol.feed(good, 2 * NS)) == 1
    assert protocol.feed(good, 2 * NS) == []
    assert len(protocol.feed(wire.packet(wire.pixels(), seq=9), 3 * NS)) == 1
    assert +protocol.counters == {
        "truncated_record": 4, "unknown_message": 1, "bad_checksum": 1, "short_record": 1, "overlong_record": 1,
        "garbage_bytes": sum(map(len, bad)) + 8, "records": 7, "other_records": 2, "bad_ping": 2, "pings": 2,
        "duplicate_pings": 1, "lost_pings": 3,
    }  # fmt: skip
    assert set(protocol.counters) <= set(COUNTERS["sonar"])


def test_no_time_is_that_of_the_arrival() -> None:
    protocol = made()
    (ping,) = protocol.feed(wire.packet(wire.pixels(), time=(0, 0)), 7 * NS)
    assert ping.t_ns == 7 * NS - LISTENING_NS
    assert protocol.counters["no_device_time"] == 1


@given(st.binary(max_size=300), st.booleans())
def test_any_datagram_is_survived(content: bytes, sealed: bool) -> None:
    protocol = made()
    protocol.feed(wire.sealed(content) if sealed else b"RIP2" + content, NS)
    assert protocol.counters["pings"] == 0


def why(protocol: Sonar3d15Protocol) -> str:
    protocol.check(0)
    assert protocol.problems(4 * NS) == []
    (said,) = protocol.problems(6 * NS)
    assert protocol.diagnosis(6.0) == said
    return said


def test_silence_is_said_with_its_likely_causes() -> None:
    said = why(made(interface="192.168.194.90", sender="192.168.194.96"))
    parts = [
        "nothing comes from the group 224.0.0.96", "acoustics on (http://192.168.194.96)", "set to multicast",
        "interface with 192.168.194.90", "ip route get 192.168.194.96", "firewall must allow incoming UDP 4747",
    ]  # fmt: skip
    for part in parts:
        assert part in said
    assert "set sonar.sonar3d15.interface to this computer's address" in why(made())
    unicast = why(made("udp://0.0.0.0:4800"))
    assert "send by unicast to this computer, port 4800" in unicast


def test_what_comes_instead_is_said() -> None:
    protocol = made()
    protocol.feed(wire.sealed(wire.literals(wire.message("BitmapImageGreyscale8", b""))), NS)
    assert why(protocol).startswith("it sends pictures of signal strength, not range images: are its acoustics on")
    protocol = made()
    protocol.feed(b"$GPGGA,", NS)
    assert why(protocol) == "the data at UDP port 4747 are not packets of a Sonar 3D-15: is it another program's?"
    protocol = made()
    protocol.feed(wire.packet(wire.pixels())[:-3], NS)
    assert why(protocol).startswith("its packets arrive damaged or truncated")
    protocol = made(sender="10.0.0.1")
    protocol.counters["stranger_datagrams"] = 3
    assert why(protocol).startswith("datagrams come, but none from 10.0.0.1")


def test_it_is_spoken_over_udp_only_and_addresses_are_checked() -> None:
    with pytest.raises(ValueError, match="sonar3d15 works over udp only"):
        SonarSettings(protocol="sonar3d15", port="tcp://10.0.0.1:4747")
    with pytest.raises(ValueError, match="needs a port number"):
        SonarSettings(protocol="sonar3d15", port="udp://224.0.0.96")
    with pytest.raises(ValueError, match="interface: eth0: not an IP address"):
        Sonar3d15Settings(interface="eth0")
    with pytest.raises(ValueError, match="s7k works over serial, socket, tcp only"):
        SonarSettings(port=GROUP)
    assert unsupported_reason(SonarSettings(protocol="sonar3d15", port=GROUP)) == ""
