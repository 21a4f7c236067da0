"""Strangers without a cookie: half requests, endless headers and bodies cost the workbench neither memory nor files."""

import contextlib
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from ods.workbench.web.limits import MOST_CONNECTIONS, MOST_HEAD_BYTES
from tests.workbench.serving import Serving, serving

PATIENCE_S = 20.0


@pytest.fixture(scope="module")
def workbench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Serving]:
    with serving(folder=tmp_path_factory.mktemp("work")) as server:
        yield server


def connected(server: Serving) -> socket.socket:
    host, port = server.origin.removeprefix("http://").split(":")
    return socket.create_connection((host, int(port)), timeout=PATIENCE_S)


def descriptors(server: Serving) -> int:
    return len([*Path(f"/proc/{server.process.pid}/fd").iterdir()])


def memory_mb(server: Serving) -> float:
    return int(Path(f"/proc/{server.process.pid}/statm").read_text().split()[1]) * 4096 / 1e6


def is_hung_up(peer: socket.socket) -> bool:
    try:
        while peer.recv(65536):
            pass
    except TimeoutError:
        return False
    except OSError:
        return True
    return True


def taken(peer: socket.socket, part: bytes, most: int) -> int:
    """Send a part again and again; return how many bytes were taken before the workbench hung up."""
    sent = 0
    with contextlib.suppress(OSError):
        while sent < most:
            sent += peer.send(part)
    return sent


def test_half_requests_take_the_place_of_each_other_only(workbench: Serving) -> None:
    browser, before = workbench.client(), descriptors(workbench)
    peers = [connected(workbench) for _ in range(2 * MOST_CONNECTIONS)]
    for peer in peers:
        peer.sendall(b"GET / HTTP/1.1\r\nHost:")
    assert is_hung_up(peers[0])
    assert descriptors(workbench) <= before + MOST_CONNECTIONS + 2
    assert browser.get("/").status_code == 200
    for peer in peers:
        peer.close()


@pytest.mark.parametrize("line", [b"X: %b\r\n" % (b"x" * 1000), b"x" * 1000], ids=["lines", "line"])
def test_endless_headers_are_refused(workbench: Serving, line: bytes) -> None:
    before = memory_mb(workbench)
    with connected(workbench) as peer:
        peer.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n")
        sent = taken(peer, line * 100, 50_000_000)
        assert sent < 200 * MOST_HEAD_BYTES  # what the kernel holds is among it
    assert memory_mb(workbench) < before + 20.0


def test_a_body_without_a_cookie_is_not_kept(workbench: Serving) -> None:
    before = memory_mb(workbench)
    with connected(workbench) as peer:
        peer.sendall(b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000000000\r\n\r\n")
        assert taken(peer, bytes(100_000), 10**9) < 10**8
    assert memory_mb(workbench) < before + 20.0
