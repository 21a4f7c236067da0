"""The sender over real sockets: a receiver that is away, that comes back, and no way there."""

import socket
from collections import Counter

import pytest

from ods.base import clock
from ods.bridge.settings import Destination
from ods.bridge.udp_sender import REPORTED_NS, UdpSender


class Complaints:
    """Counts, and keeps what is said."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.said: list[str] = []

    def __call__(self, name: str, text: str) -> None:
        self.counts[name] += 1
        self.said.append(text)


def receiver(host: str = "127.0.0.1", port: int = 0) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    made = socket.socket(family, socket.SOCK_DGRAM)
    made.bind((host, port))
    made.settimeout(10.0)
    return made


@pytest.mark.parametrize("host", ["127.0.0.1", "::1"])
def test_datagrams_arrive_as_they_are(host: str) -> None:
    complaints = Complaints()
    with receiver(host) as peer:
        sender = UdpSender(Destination(host, peer.getsockname()[1]), complaints)
        assert sender.send([b"one", b"two"]) == 2
        assert [peer.recv(100), peer.recv(100)] == [b"one", b"two"]
        sender.close()
    assert (complaints.counts, sender.problem(clock.monotonic_ns())) == ({}, "")


def test_a_receiver_that_is_away_is_reported_and_gets_all_once_it_is_back() -> None:
    complaints = Complaints()
    with receiver() as peer:
        port = peer.getsockname()[1]
    sender = UdpSender(Destination("127.0.0.1", port), complaints)
    assert sender.send([b"lost", b"lost", b"lost"]) == 3
    assert complaints.counts["refused_datagrams"] > 0
    now_ns = clock.monotonic_ns()
    assert sender.problem(now_ns) == f"127.0.0.1 port {port}: no process listens there"
    assert sender.problem(now_ns + REPORTED_NS) == ""
    with receiver(port=port) as peer:
        assert sender.send([b"one", b"two"]) == 2
        assert [peer.recv(100), peer.recv(100)] == [b"one", b"two"]
    sender.close()


def test_what_cannot_be_sent_is_counted_and_the_next_one_is_tried() -> None:
    complaints = Complaints()
    with receiver() as peer:
        sender = UdpSender(Destination("127.0.0.1", peer.getsockname()[1]), complaints)
        assert sender.send([b"x" * 70_000, b"fits"]) == 1
        assert peer.recv(100) == b"fits"
        sender.close()
    assert complaints.counts == {"unsent_datagrams": 1}
    assert "too long" in complaints.said[0]


def test_no_way_there_is_reported() -> None:
    complaints = Complaints()
    sender = UdpSender(Destination("127.255.255.255", 5005), complaints)  # a broadcast address: the kernel refuses
    assert sender.send([b"one", b"two"]) == 0
    assert complaints.counts == {"unsent_datagrams": 2}
    assert sender.problem(clock.monotonic_ns()).startswith("127.255.255.255 port 5005: ")
    sender.close()
