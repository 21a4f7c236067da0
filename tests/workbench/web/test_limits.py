"""Connections that never finish their request's head: bounded in bytes, in number and in time, on real sockets."""

import socket
import threading
import time
from collections.abc import Iterator

import pytest
import uvicorn

from ods.workbench.web import limits
from ods.workbench.web.limits import MOST_HEAD_BYTES, BoundedProtocol

HALF = b"GET / HTTP/1.1\r\nHost: localhost\r\n"
FEW, SOON_S = 10, 1.0


async def answer(scope: object, receive: object, send: object) -> None:
    """The smallest application."""
    assert callable(send)
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
    await send({"type": "http.response.body", "body": b"ok"})


@pytest.fixture
def address(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[str, int]]:
    monkeypatch.setattr(limits, "MOST_CONNECTIONS", FEW)
    monkeypatch.setattr(limits, "PATIENCE_S", SOON_S)
    bound = socket.socket()
    bound.bind(("127.0.0.1", 0))
    config = uvicorn.Config(
        answer, http=BoundedProtocol, h11_max_incomplete_event_size=MOST_HEAD_BYTES, log_config=None, lifespan="off"
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [bound]})
    thread.start()
    while not server.started:
        time.sleep(0.01)
    yield bound.getsockname()
    server.should_exit = True
    thread.join()


def connected(address: tuple[str, int], sent: bytes = HALF) -> socket.socket:
    line = socket.create_connection(address, timeout=20.0)
    line.sendall(sent)
    return line


def is_closed(line: socket.socket) -> bool:
    try:
        return line.recv(4096) == b""
    except ConnectionResetError:
        return True


def test_half_requests_are_closed_after_a_while_and_others_are_answered_meanwhile(address: tuple[str, int]) -> None:
    half = [connected(address) for _ in range(5 * FEW)]
    whole = connected(address, HALF + b"\r\n")
    assert whole.recv(4096).startswith(b"HTTP/1.1 200")
    assert all(is_closed(line) for line in half)


def test_of_very_many_the_oldest_goes(address: tuple[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "PATIENCE_S", 60.0)
    first = connected(address)
    others = [connected(address) for _ in range(FEW)]
    assert is_closed(first)
    others[-1].sendall(b"\r\n")
    assert others[-1].recv(4096).startswith(b"HTTP/1.1 200")


def test_a_second_half_request_on_the_same_connection_is_not_waited_for_either(address: tuple[str, int]) -> None:
    line, answered = connected(address, HALF + b"\r\n"), b""
    while not answered.endswith(b"\r\n\r\nok"):  # head and body may come apart
        part = line.recv(4096)
        assert part
        answered += part
    line.sendall(HALF)
    assert is_closed(line)


def send_lines(line: socket.socket, count: int) -> None:
    for _ in range(count):
        line.sendall(b"X: " + b"x" * 10_000 + b"\r\n")
        time.sleep(0.001)


def test_an_endless_head_is_refused(address: tuple[str, int]) -> None:
    with pytest.raises((ConnectionResetError, BrokenPipeError)):
        send_lines(connected(address), 1000)
