"""The real sonar process and the doctor with a Sonar 3D-15 over real multicast at the loopback interface."""

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
from ods.sim_sonar.device.lines.multicast_line import MulticastLine
from tests.sonar_link.sonar3d15 import wire

CONFIG = Path(__file__).parents[3] / "config" / "onboard-sonar3d15.toml"
GROUP = "224.0.0.96"
HERE = "127.0.0.1"
PATIENCE_S = 30.0
EDS = {"ins_eds": "ins", "node_eds": "ods_node"}


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind((HERE, 0))
        return int(one.getsockname()[1])


class SimulatedSonar:
    """Sends an image each 20 ms, or what it is reported to send."""

    def __init__(self, port: int, *, always: bytes = b"", group: str = GROUP) -> None:
        self._line = MulticastLine(group, port)
        self._always = always
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._send)
        self._thread.start()

    def close(self) -> None:
        self._stopping.set()
        self._thread.join()
        self._line.unplug()

    def _send(self) -> None:
        number = 0
        while not self._stopping.wait(0.02):
            number += 1
            now = utc_ns()
            image = wire.packet(wire.pixels(number, 256, 64), seq=number, time=(now // NS, now % NS))
            self._line.write([self._always or image], 0.0)


def sonar_of(port: int, **own: str) -> dict[str, Any]:
    return {"protocol": "sonar3d15", "port": f"udp://{GROUP}:{port}", "sonar3d15": {"interface": HERE} | own}


class Process:
    """A running sonar process, and what it says."""

    def __init__(self, folder: Path, sonar: dict[str, Any]) -> None:
        self.pings: list[Ping] = []
        self.health: Health | None = None
        content: dict[str, Any] = {
            "bus": {"run_dir": str(folder)},
            "site": {"latitude_deg": 57.0, "longitude_deg": 9.9},
            "sonar": sonar,
            "nav": {
                "can": {"interface": "virtual", "channel": "none"},
                "canopen": {name: str(CONFIG.with_name(f"{file}.eds")) for name, file in EDS.items()},
            },
        }
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

    def says(self, words: str) -> bool:
        return self.health is not None and any(words in problem for problem in self.health.problems)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        self._subscriber.close()
        self._context.term()


@contextlib.contextmanager
def running(sonar: dict[str, Any]) -> Iterator[Process]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        process = Process(Path(folder), sonar)
        try:
            yield process
        finally:
            process.close()


@pytest.mark.timeout(120)
def test_images_come_whole_and_silence_is_said_and_ends() -> None:
    port = free_port()
    with running(sonar_of(port, sender=HERE)) as process:
        process.wait(lambda: process.says(f"nothing comes from the group {GROUP}"))
        end = SimulatedSonar(port)
        try:
            process.wait(lambda: len(process.pings) > 5)
            ping = process.pings[-1]
            np.testing.assert_array_equal(frame_of(ping), wire.pixels(ping.ping_number, 256, 64).T)
            assert ping.range_grid is not None
            assert len(ping.range_grid.elevation_rad) == 64
            process.wait(lambda: process.health and not process.health.problems)
            assert process.health is not None
            assert not process.health.counters.keys() & {"bad_ping", "bad_checksum", "truncated_record", "lost_pings"}
        finally:
            end.close()


@pytest.mark.timeout(120)
def test_what_others_send_is_left_out() -> None:
    port = free_port()
    end = SimulatedSonar(port)
    try:
        with running(sonar_of(port, sender="192.0.2.7")) as process:
            process.wait(lambda: process.says("datagrams come, but none from 192.0.2.7"))
            assert process.pings == []
    finally:
        end.close()


@pytest.mark.timeout(120)
def test_an_interface_that_is_not_here_is_said() -> None:
    with running(sonar_of(free_port()) | {"sonar3d15": {"interface": "192.0.2.90"}}) as process:
        process.wait(lambda: process.says(f"cannot join {GROUP} at the interface with 192.0.2.90"))


def received(tmp_path: Path, port: int, seconds: float, address: str = GROUP) -> list[str]:
    shipped = load(CONFIG, OnboardConfig)
    own = msgspec.structs.replace(shipped.sonar.sonar3d15, interface=HERE, sender="")
    sonar = msgspec.structs.replace(shipped.sonar, port=f"udp://{address}:{port}", sonar3d15=own)
    settings = msgspec.structs.replace(shipped, sonar=sonar, bus=BusSettings(run_dir=tmp_path))
    return [f"{found.level} {found.text}" for found in sonar_port.listen(settings, seconds)]


def test_the_doctor_hears_its_images_by_multicast_and_by_unicast(tmp_path: Path) -> None:
    for address, group in ((GROUP, GROUP), (HERE, HERE)):
        port = free_port()
        end = SimulatedSonar(port, group=group)
        try:
            good, *_ = received(tmp_path, port, 1.0, address)
        finally:
            end.close()
        assert good.startswith("good ")
        assert "pings/s; range images at " in good


def test_the_doctor_says_what_to_look_at(tmp_path: Path) -> None:
    wrong, *_ = received(tmp_path, free_port(), 0.3)
    assert wrong.startswith(f"wrong nothing comes from the group {GROUP}: is the sonar on")
    (note,) = sonar_port.examine("udp://224.0.0.96:4747")
    assert (note.level, note.text) == ("note", "datagrams: only `ods doctor --listen` can show whether any arrive")
