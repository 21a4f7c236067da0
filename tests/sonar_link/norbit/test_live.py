"""The real sonar process and the doctor with a Norbit over real TCP sockets, one for images and one for commands."""

import contextlib
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import tomli_w
import zmq

from ods.base.clock import NS, utc_ns
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.doctor.lines import sonar_port
from ods.messages import Health, Ping, frame_of
from ods.runtime import bus
from ods.runtime.bus import BusSettings
from tests.sonar_link.norbit import wire

CONFIG = Path(__file__).parents[3] / "config" / "onboard-norbit.toml"
PATIENCE_S = 30.0
EDS = {"ins_eds": "ins", "node_eds": "ods_node"}


class SimulatedSonar:
    """A WBMS made of sockets. It answers each command with itself, and pings when it was asked to."""

    def __init__(self, *, answers: bool = True, always: bytes = b"") -> None:
        self.asked: list[str] = []
        self.images = socket.create_server(("127.0.0.1", 0))
        self.commands = socket.create_server(("127.0.0.1", 0))
        self.clients: list[socket.socket] = []
        self.talkers: list[socket.socket] = []
        self._answers = answers
        self._always = always
        self._stopping = threading.Event()
        self._threads = [threading.Thread(target=self._talk), threading.Thread(target=self._ping)]
        for thread in self._threads:
            thread.start()

    @property
    def ports(self) -> tuple[int, int]:
        """Of images and commands."""
        return self.images.getsockname()[1], self.commands.getsockname()[1]

    def hang_up(self) -> None:
        """End the connection of the images."""
        self.clients[-1].shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        self._stopping.set()
        for thread in self._threads:
            thread.join()
        self.images.close()
        self.commands.close()

    def _accept(self, server: socket.socket) -> socket.socket | None:
        with contextlib.suppress(OSError):  # nobody has come, or the test has closed it
            server.settimeout(0.05)
            client, _ = server.accept()
            client.settimeout(0.05)
            return client
        self._stopping.wait(0.01)
        return None

    def _talk(self) -> None:
        while not self._stopping.is_set():
            client = self._accept(self.commands)
            if client is None:
                continue
            self.talkers.append(client)
            with client, contextlib.suppress(OSError):
                client.sendall(b"NORBIT WBMS\r\nSonar is ready\r\n")
                rest = b""
                while not self._stopping.is_set():
                    with contextlib.suppress(TimeoutError):
                        data = client.recv(4096)
                        if not data:
                            break
                        *lines, rest = (rest + data).split(b"\r\n")
                        for line in lines:
                            self.asked.append(line.decode())
                            if self._answers:
                                client.sendall(line + b" # as asked\r\n")

    def _ping(self) -> None:
        number = 0
        while not self._stopping.is_set():
            client = self._accept(self.images)
            if client is None:
                continue
            self.clients.append(client)
            with client, contextlib.suppress(OSError):
                while not self._stopping.wait(0.02):
                    number += 1
                    if self._always:
                        client.sendall(self._always)
                    elif self._answers and self.asked and self.asked[-1] == "set_power 1":
                        client.sendall(packet(number))


def packet(number: int) -> bytes:
    return wire.image(wire.samples(number, 500, 64), number=number, time=utc_ns() / NS)


class Process:
    """A running sonar process, and what it says."""

    def __init__(self, folder: Path, ports: tuple[int, int]) -> None:
        self.pings: list[Ping] = []
        self.health: Health | None = None
        content: dict[str, Any] = {
            "bus": {"run_dir": str(folder)},
            "site": {"latitude_deg": 57.0, "longitude_deg": 9.9},
            "sonar": {
                "protocol": "norbit", "port": f"tcp://127.0.0.1:{ports[0]}", "silence_s": 1.0, "reopen_max_s": 0.2,
                "norbit": {"command_port": ports[1]},
            },
            "nav": {
                "can": {"interface": "virtual", "channel": "none"},
                "canopen": {name: str(CONFIG.with_name(f"{file}.eds")) for name, file in EDS.items()},
            },
        }  # fmt: skip
        config = folder / "onboard.toml"
        config.write_text(tomli_w.dumps(content), encoding="utf-8")
        self._process = subprocess.Popen([sys.executable, "-m", "ods", "sonar", "--config", str(config)])
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._subscriber = bus.Subscriber(self._context, folder, ["ping"], ["sonar"])

    def wait(self, wanted: Callable[[], Any]) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < deadline, (self.health, len(self.pings))
            for topic, message in self._subscriber.receive(0.05)[0]:
                if topic == "ping":
                    self.pings.append(message)
                else:
                    self.health = message

    def counter(self, name: str) -> int:
        return self.health.counters.get(name, 0) if self.health else 0

    def says(self, words: str) -> bool:
        return self.health is not None and any(words in problem for problem in self.health.problems)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        self._subscriber.close()
        self._context.term()


@contextlib.contextmanager
def running(end: SimulatedSonar) -> Iterator[Process]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        process = Process(Path(folder), end.ports)
        try:
            yield process
        finally:
            process.close()
            end.close()


@pytest.mark.timeout(120)
def test_it_is_reported_what_to_do_and_its_images_come_also_after_a_lost_connection() -> None:
    end = SimulatedSonar()
    with running(end) as process:
        process.wait(lambda: len(process.pings) > 3)
        ping = process.pings[-1]
        np.testing.assert_array_equal(frame_of(ping), wire.samples(ping.ping_number, 500, 64).T)
        asked = list(dict.fromkeys(end.asked))
        assert asked[0] == "set_mode 0"
        assert asked[-1] == "set_power 1"
        process.wait(lambda: process.health and not process.health.problems)
        before = len(end.asked)
        end.hang_up()
        process.wait(lambda: process.counter("port_losses") == 1 and len(end.asked) >= before + len(asked))
        newest = process.pings[-1].ping_number
        process.wait(lambda: process.pings[-1].ping_number > newest + 3)
        process.wait(lambda: process.counter("port_opens") == 2)
        assert process.counter("bad_checksum") == 0
        assert process.counter("control_lost") == 0


@pytest.mark.timeout(120)
def test_a_lost_command_port_costs_no_image_and_is_spoken_to_again() -> None:
    end = SimulatedSonar()
    with running(end) as process:
        process.wait(lambda: len(process.pings) > 3)
        before = len(end.asked)
        end.talkers[-1].shutdown(socket.SHUT_RDWR)
        process.wait(lambda: end.asked.count("set_power 1") == 2 and len(end.asked) >= 2 * before)
        newest = process.pings[-1].ping_number
        process.wait(lambda: process.pings[-1].ping_number > newest + 3)
        end.commands.close()
        end.talkers[-1].shutdown(socket.SHUT_RDWR)
        seen = process.health.seq if process.health else 0
        process.wait(lambda: process.health and process.health.seq > seen + 3)
        assert process.health is not None
        assert process.health.problems == []
        assert process.counter("port_losses") == 0


@pytest.mark.timeout(120)
def test_connected_but_no_image_is_said_with_its_cause() -> None:
    with running(SimulatedSonar(answers=False)) as process:
        process.wait(lambda: process.says("the sonar does not answer commands: is `command_port` that of a WBMS?"))


def received(tmp_path: Path, end: SimulatedSonar, seconds: float) -> list[str]:
    shipped = load(CONFIG, OnboardConfig)
    norbit = msgspec.structs.replace(shipped.sonar.norbit, command_port=end.ports[1])
    sonar = msgspec.structs.replace(shipped.sonar, port=f"tcp://127.0.0.1:{end.ports[0]}", norbit=norbit)
    settings = msgspec.structs.replace(shipped, sonar=sonar, bus=BusSettings(run_dir=tmp_path))
    try:
        return [f"{found.level} {found.text}" for found in sonar_port.listen(settings, seconds)]
    finally:
        end.close()


def test_the_doctor_hears_its_images(tmp_path: Path) -> None:
    good, *_ = received(tmp_path, SimulatedSonar(), 1.5)
    assert good.startswith("good ")
    assert "pings/s; images at " in good


def test_the_doctor_says_that_the_port_is_that_of_the_bathymetry(tmp_path: Path) -> None:
    wrong, *_ = received(tmp_path, SimulatedSonar(always=wire.sealed(bytes(88), 1)), 0.6)
    assert wrong.startswith("wrong it sends bathymetry, not images: these use sonar.port ")


def test_the_doctor_says_what_to_look_at_when_it_is_connected_but_no_image_comes(tmp_path: Path) -> None:
    wrong, *_ = received(tmp_path, SimulatedSonar(answers=False), 0.6)
    assert wrong == "wrong connected, but no image: it has not answered any command yet"
