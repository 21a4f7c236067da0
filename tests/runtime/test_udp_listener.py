"""Announcements by UDP, on real sockets: received, shared, bounded; a port that is taken is said and tried again."""

import socket
from collections.abc import Iterator

import pytest

from ods.runtime.port.udp_listener import MAX_DATAGRAMS, Datagram, UdpListener

S = 1_000_000_000


@pytest.fixture
def port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        number: int = probe.getsockname()[1]
    return number


@pytest.fixture
def sender() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        yield made


def test_datagrams_come_whole_with_their_sender_and_a_flood_in_portions(port: int, sender: socket.socket) -> None:
    listener = UdpListener(port)
    assert listener.receive(0) == []
    for number in range(MAX_DATAGRAMS + 1):
        sender.sendto(b"x" * number, ("127.0.0.1", port))
    received = listener.receive(0)
    assert received == [Datagram(b"x" * number, "127.0.0.1") for number in range(MAX_DATAGRAMS)]
    assert listener.receive(0) == [Datagram(b"x" * MAX_DATAGRAMS, "127.0.0.1")]
    listener.close()


def test_two_listeners_share_a_port_and_both_hear_a_broadcast(port: int, sender: socket.socket) -> None:
    listeners = UdpListener(port), UdpListener(port)
    assert [listener.receive(0) for listener in listeners] == [[], []]
    sender.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
    sender.sendto(b"here", ("127.255.255.255", port))
    for listener in listeners:
        assert [datagram.data for datagram in listener.receive(0)] == [b"here"]
        listener.close()


def test_a_port_that_is_taken_is_said_and_tried_again_after_a_second(port: int, sender: socket.socket) -> None:
    listener = UdpListener(port)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("", port))
        assert listener.receive(0) == []
        assert listener.fault == f"UDP port {port}: Address already in use"
    assert listener.receive(S - 1) == []
    assert listener.fault
    assert listener.receive(S) == []
    assert not listener.fault
    sender.sendto(b"here", ("127.0.0.1", port))
    assert [datagram.data for datagram in listener.receive(S)] == [b"here"]
    listener.close()
