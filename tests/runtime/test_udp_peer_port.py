"""A UDP peer as a port: refused, back again, silent, and strangers."""

import socket
import time
from collections import Counter

from ods.base.clock import NS
from ods.runtime.port.address import UdpAddress
from ods.runtime.port.udp_peer_port import UdpPeerPort

PATIENCE_S = 10.0


def server(port: int = 0) -> socket.socket:
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.bind(("127.0.0.1", port))
    made.settimeout(PATIENCE_S)
    return made


def received(port: UdpPeerPort, now_ns: int) -> bytes:
    """Wait for what comes."""
    until_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < until_s:
        if data := port.read(now_ns):
            return data
        time.sleep(0.001)
    return b""


def made(address: tuple[str, int], counters: "Counter[str]", silence_s: float = 0.0) -> UdpPeerPort:
    return UdpPeerPort(UdpAddress(*address), silence_s, (0.1, 1.0), counters)


def test_nobody_there_is_a_fault_and_who_comes_later_is_spoken_with() -> None:
    with server() as gone:
        address = gone.getsockname()
    counters: Counter[str] = Counter()
    port = made(address, counters)
    assert port.open_if_due(0)
    assert port.write(b"hello", 0)
    until_s = time.monotonic() + PATIENCE_S
    while port.fd is not None and time.monotonic() < until_s:  # the refusal is on its way
        port.check(0)
    assert "refused" in port.fault
    assert counters["port_losses"] == 1
    with server(address[1]) as there:
        assert not port.open_if_due(NS // 20)
        assert port.open_if_due(NS)
        assert port.write(b"hello", NS)
        data, peer = there.recvfrom(100)
        assert data == b"hello"
        there.sendto(b"a beam", peer)
        assert received(port, NS) == b"a beam"
    port.close()


def test_strangers_are_not_received() -> None:
    with server() as there, server() as stranger:
        port = made(there.getsockname(), Counter())
        port.open_if_due(0)
        port.write(b"hello", 0)
        _, peer = there.recvfrom(100)
        stranger.sendto(b"mine", peer)
        there.sendto(b"its own", peer)
        assert received(port, 0) == b"its own"
        assert port.read(0) == b""
        port.close()


def test_silence_ends_it() -> None:
    with server() as there:
        port = made(there.getsockname(), Counter(), silence_s=5.0)
        port.open_if_due(0)
        opened = []
        for seconds in (5, 6):
            port.check(seconds * NS)
            opened.append(port.fd is not None)
        assert opened == [True, False]
        assert "silent for 5 s" in port.fault
