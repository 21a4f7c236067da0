"""The TCP port against real sockets: connecting never blocks; lost, refused and half-open connections come back."""

import socket
import struct
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from ods.runtime.port.address import TcpAddress, tcp_address
from ods.runtime.port.tcp_port import CONNECT_S, TcpPort
from ods.sonar_link.settings import SonarSettings

MS = 1_000_000
S = 1_000_000_000
PATIENCE_S = 10.0


@pytest.fixture
def server() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as made:
        made.settimeout(PATIENCE_S)
        yield made


def make_port(server: socket.socket, silence_s: float = 5.0) -> TcpPort:
    host, number = server.getsockname()[:2]
    return TcpPort(TcpAddress(host, number, "tcp"), silence_s, (0.1, 1.0))


def until(wanted: Callable[[], Any]) -> None:
    """Try again until the kernel has done its part."""
    deadline = time.monotonic() + PATIENCE_S
    while not wanted():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def connected(port: TcpPort, server: socket.socket, now_ns: int = 0) -> socket.socket:
    until(lambda: port.open_if_due(now_ns))
    far, _ = server.accept()
    far.settimeout(PATIENCE_S)
    return far


def lost(port: TcpPort, now_ns: int) -> bool:
    port.read(now_ns)
    return port.fd is None


def test_bytes_go_both_ways_unchanged(server: socket.socket) -> None:
    port = make_port(server)
    assert port.fault.endswith("not opened yet")
    assert port.fd is None
    far = connected(port, server)
    assert (port.fault, port.read(0)) == ("", b"")
    far.sendall(bytes(range(256)))
    received = bytearray()
    until(lambda: len(received.__iadd__(port.read(0))) == 256)
    assert received == bytes(range(256))
    assert port.write(b"request", 0)
    assert far.recv(100) == b"request"
    assert port.counters == {"port_opens": 1}
    port.close()
    assert far.recv(100) == b""
    far.close()


def test_a_closed_and_a_reset_connection_are_distinguished_and_made_again(server: socket.socket) -> None:
    port = make_port(server)
    far = connected(port, server)
    far.close()
    until(lambda: lost(port, S))
    assert port.fault.endswith("the other end closed the connection")
    assert not port.open_if_due(S + 99 * MS)
    far = connected(port, server, S + 100 * MS)
    far.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    far.close()  # with a reset
    until(lambda: lost(port, 2 * S))
    assert port.fault.endswith("connection reset by peer")
    connected(port, server, 3 * S).close()
    assert (port.counters["port_opens"], port.counters["port_losses"]) == (3, 2)


def test_a_server_away_is_tried_with_growing_pauses_and_found_when_it_is_back() -> None:
    with socket.create_server(("127.0.0.1", 0)) as first:
        port = make_port(first)
        number = first.getsockname()[1]
    tried = []
    for ms in range(0, 5000, 10):
        before = port.counters["port_open_errors"]
        port.open_if_due(ms * MS)
        if port.counters["port_open_errors"] > before:
            tried.append(ms)
    assert tried == [0, 100, 300, 700, 1500, 2500, 3500, 4500]
    assert port.fault == f"127.0.0.1 port {number}: connection refused"
    with socket.create_server(("127.0.0.1", number)) as second:
        second.settimeout(PATIENCE_S)
        far = connected(port, second, 6 * S)
        assert port.fault == ""
        far.close()
    port.close()


def test_a_half_open_connection_is_given_up_after_a_silence(server: socket.socket) -> None:
    port = make_port(server, silence_s=2.0)
    far = connected(port, server)
    far.sendall(b"x")
    until(lambda: port.read(S) == b"x")
    port.check(3 * S)
    assert port.fault == ""
    port.check(3 * S + 1)
    assert port.fd is None
    assert port.fault.endswith("connected, but silent for 2 s")
    again = connected(port, server, 4 * S)
    port.check(5 * S)
    assert port.fault == ""
    for end in (far, again):
        end.close()
    port.close()


def test_silence_may_be_allowed(server: socket.socket) -> None:
    port = make_port(server, silence_s=0.0)
    far = connected(port, server)
    port.check(10**6 * S)
    assert port.fd is not None
    far.close()
    port.close()


def test_a_host_that_does_not_answer_is_given_up_without_blocking() -> None:
    with socket.socket() as deaf:
        deaf.bind(("127.0.0.1", 0))
        deaf.listen(0)
        crowd = [socket.socket() for _ in range(4)]  # the kernel drops what comes once its queue is full
        for one in crowd:
            one.setblocking(False)
            one.connect_ex(deaf.getsockname())
        port = make_port(deaf)
        begun = time.process_time(), time.monotonic()
        assert not any(port.open_if_due(tenth * 100 * MS) for tenth in range(round(CONNECT_S * 10) + 1))
        assert port.counters["port_open_errors"] == 0
        assert not port.open_if_due(round(CONNECT_S * S) + 1)
        assert time.monotonic() - begun[1] < CONNECT_S
        assert port.fault.endswith("no answer within 5 s")
        for one in crowd:
            one.close()


def test_a_peer_that_takes_nothing_is_given_up_before_half_a_packet_spoils_the_rest(server: socket.socket) -> None:
    port = make_port(server)
    far = connected(port, server)
    assert not port.write(bytes(1 << 26), 0)
    assert port.fault.endswith("the other end does not accept data")
    assert port.fd is None
    far.close()
    port.close()


@pytest.mark.parametrize(
    ("port", "words"),
    [
        ("tcp://sonar:7000", 'needs an IP address, such as "tcp://192.168.0.5:7000"'),
        ("tcp://192.168.0.5", "needs a port number"),
        ("tcp://192.168.0.5:0", "needs a port number"),
        ("tcp://192.168.0.5:70000", "needs a port number"),
        ("rfc2217://192.168.0.5:7000", "neither a device nor an address"),
    ],
)
def test_a_wrong_address_is_one_line_that_names_the_key(port: str, words: str) -> None:
    with pytest.raises(ValueError, match=r"^port: ") as error:
        SonarSettings(port=port)
    assert words in str(error.value)


def test_addresses() -> None:
    assert tcp_address("tcp://10.0.0.5:7000") == ("10.0.0.5", 7000, "tcp")
    assert tcp_address("socket://10.0.0.5:4001") == ("10.0.0.5", 4001, "socket")
    assert tcp_address("tcp://[::1]:7000") == ("::1", 7000, "tcp")
    assert tcp_address("/dev/serial/by-id/usb") is None
