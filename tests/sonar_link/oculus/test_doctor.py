"""What `ods doctor --listen` says of an Oculus, over real sockets."""

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import msgspec
import pytest

from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.doctor.finding import Finding
from ods.doctor.lines import sonar_port
from ods.runtime.bus import BusSettings
from tests.sonar_link.oculus import wire

CONFIG = Path(__file__).parents[3] / "config" / "onboard-oculus.toml"


def free_udp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def settings_for(folder: Path, port: int, status_port: int) -> OnboardConfig:
    shipped = load(CONFIG, OnboardConfig)
    oculus = msgspec.structs.replace(shipped.sonar.oculus, status_port=status_port)
    sonar = msgspec.structs.replace(shipped.sonar, port=f"tcp://127.0.0.1:{port}", oculus=oculus)
    return msgspec.structs.replace(shipped, sonar=sonar, bus=BusSettings(run_dir=folder))


@contextmanager
def repeating(step: Callable[[], Any]) -> Iterator[None]:
    """Do `step` again and again."""
    stopping = threading.Event()

    def run() -> None:
        while not stopping.wait(0.02):
            step()

    thread = threading.Thread(target=run)
    thread.start()
    yield
    stopping.set()
    thread.join()


def received(
    tmp_path: Path, message: Callable[[int], bytes], status: bytes | None, seconds: float = 0.6
) -> list[Finding]:
    """Listen to a sonar that sends `message` of 1, 2, ... and `status`."""
    status_port = free_udp_port()
    with (
        socket.create_server(("127.0.0.1", 0)) as server,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        clients: list[socket.socket] = []
        numbers = iter(range(1, 10_000))

        def step() -> None:
            if not clients:
                clients.append(server.accept()[0])
            if status:
                sender.sendto(status, ("127.0.0.1", status_port))
            with suppress(OSError):  # the doctor has hung up
                clients[0].sendall(message(next(numbers)))

        with repeating(step):
            found = list(sonar_port.listen(settings_for(tmp_path, server.getsockname()[1], status_port), seconds))
        clients[0].close()
    return found


def test_pings_and_who_sends_them(tmp_path: Path) -> None:
    good, *_ = received(
        tmp_path, lambda number: wire.ping(wire.image(number), number=number, gamma=127), wire.status("127.0.0.1")
    )
    assert good.level == "good"
    assert "pings/s; ping results at " in good.text
    assert "Hz from M750d number 7892 at 127.0.0.1, 32 deg C at its warmest" in good.text


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (bytes(wire.header(0xFF, 16)), "it is in standby and ignores the fire message"),
        (bytes(wire.header(0x22, 300)), "it sends full ping results for another program"),
        (wire.ping(wire.image(1), dr=-1.0), "its ping results cannot be decoded: see the counters"),
    ],
)
def test_why_there_is_no_ping(tmp_path: Path, message: bytes, said: str) -> None:
    wrong, *_ = received(tmp_path, lambda _: message, None)
    assert wrong.level == "wrong"
    assert said in wrong.text


def test_a_wrong_address_is_reported_by_the_status_of_the_sonar_that_is_there(tmp_path: Path) -> None:
    status_port = free_udp_port()
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        other = wire.status("192.168.2.3")
        with repeating(lambda: sender.sendto(other, ("127.0.0.1", status_port))):
            (wrong,) = sonar_port.listen(settings_for(tmp_path, port, status_port), 0.5)
    assert wrong.level == "wrong"
    assert wrong.text.endswith("connection refused; a sonar at 192.168.2.3 is received (M750d): is sonar.port correct?")


def test_a_sonar_that_the_process_has_is_left_alone() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        (note,) = sonar_port.examine(f"tcp://127.0.0.1:{server.getsockname()[1]}", in_use=True)
        server.settimeout(0.1)
        with pytest.raises(TimeoutError):
            server.accept()
    assert (note.level, note.text) == ("note", "not tested: the sonar process uses its connection")
