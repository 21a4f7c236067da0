"""The real sonar and pipeline processes with an Oculus over real sockets: the recording, reconnection, the status."""

import contextlib
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
import tomli_w
import zmq

from ods.messages import Detections, Health
from ods.pipeline.offline import detect_pings
from ods.pipeline.settings import DEFAULT_STAGES, PipelineSettings
from ods.runtime import bus
from ods.sonar_link.files.opening import open_pings
from tests.recordings import OCULUS
from tests.sonar_link.oculus import wire

CONFIG = Path(__file__).parents[3] / "config"
PATIENCE_S = 120.0
"""Compiling the pipeline included."""
STAGES = [stage for stage in DEFAULT_STAGES if stage["use"] != "equalize.beam_gain"]
"""Gains are learned from ping to ping, and how many of the pings sent are received is chance."""
FIRE_BYTES = 89
RESULT_BYTES = 182016


def free_port(kind: socket.SocketKind) -> int:
    with socket.socket(socket.AF_INET, kind) as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


class Rig:
    """An Oculus made of sockets, the two processes, and what they publish."""

    def __init__(self, folder: Path, names: list[str]) -> None:
        self.server = socket.create_server(("127.0.0.1", 0))
        self.server.settimeout(PATIENCE_S)
        self.status_port = free_port(socket.SOCK_DGRAM)
        self.detections: dict[int, Detections] = {}
        self.pings: list[int] = []
        self.health: Health | None = None
        content: dict[str, Any] = {
            "bus": {"run_dir": str(folder)},
            "site": {"latitude_deg": 57.0, "longitude_deg": 9.9},
            "sonar": {
                "protocol": "oculus",
                "port": f"tcp://127.0.0.1:{self.server.getsockname()[1]}",
                "silence_s": 2.0,
                "oculus": {"mode": "high", "range_m": 2.0, "status_port": self.status_port},
            },
            "nav": {
                "can": {"interface": "virtual", "channel": "none"},
                "canopen": {"ins_eds": str(CONFIG / "ins.eds"), "node_eds": str(CONFIG / "ods_node.eds")},
            },
            "pipeline": {"stage": STAGES},
            "tracker": {"map": {"path": str(folder / "map.sqlite")}},
        }
        config = folder / "onboard.toml"
        config.write_text(tomli_w.dumps(content), encoding="utf-8")
        command = [sys.executable, "-m", "ods"]
        self._processes = [subprocess.Popen([*command, name, "--config", str(config)]) for name in names]
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._subscriber = bus.Subscriber(self._context, folder, ["ping", "detections"], ["sonar"])

    def accept(self) -> socket.socket:
        """Take the next connection."""
        client, _ = self.server.accept()
        client.settimeout(PATIENCE_S)
        return client

    def say(self, status: bytes) -> None:
        """Send a status broadcast."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(status, ("127.0.0.1", self.status_port))

    def wait(self, wanted: Callable[[], Any], meanwhile: Callable[[], object] = lambda: None) -> None:
        """Take messages until `wanted` holds."""
        deadline = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < deadline, (self.health, self.pings[-3:], len(self.detections))
            meanwhile()
            for topic, message in self._subscriber.receive(0.1)[0]:
                if topic == "ping":
                    self.pings.append(message.ping_number)
                elif topic == "detections":
                    self.detections[message.ping_number] = message
                else:
                    self.health = message

    def counter(self, name: str) -> int:
        return self.health.counters.get(name, 0) if self.health else 0

    def says(self, words: str) -> bool:
        return self.health is not None and any(words in problem for problem in self.health.problems)

    def close(self) -> None:
        for process in self._processes:
            process.kill()
            process.wait()
        self._subscriber.close()
        self._context.term()
        self.server.close()


@contextlib.contextmanager
def running(*names: str) -> Iterator[Rig]:
    with tempfile.TemporaryDirectory(prefix="ods") as folder:  # a socket path must be short
        rig = Rig(Path(folder), list(names))
        try:
            yield rig
        finally:
            rig.close()


def received(client: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count:
        data += client.recv(count - len(data))
    return data


@pytest.mark.timeout(600)
def test_the_recording_sent_by_tcp_gives_the_detections_of_the_file() -> None:
    expected = {
        result.ping.ping_number: result.detections.detections + result.detections.faint
        for result in detect_pings(open_pings(OCULUS).pings, PipelineSettings(stage=tuple(STAGES)))
    }
    assert [len(found) > 3 for found in expected.values()] == [True] * 3
    stream = OCULUS.read_bytes()
    with running("sonar", "pipeline") as rig, rig.accept() as client:
        rig.wait(
            lambda: rig.detections.keys() == expected.keys(),
            meanwhile=lambda: client.sendall(stream),  # the first ones may find no listener yet
        )
        for number, found in expected.items():
            said = rig.detections[number]
            for one, other in zip(said.detections + said.faint, found, strict=True):
                assert msgspec.structs.asdict(one) == pytest.approx(msgspec.structs.asdict(other), rel=1e-6)


@pytest.mark.timeout(120)
def test_it_fires_when_connected_again_and_says_what_the_status_tells() -> None:
    fire = wire.header(0x15, FIRE_BYTES, 2, source=0)
    wire.put_fire(fire, mode=2, gamma=127, range=2.0, gain=50.0, salinity=35.0)
    result = OCULUS.read_bytes()[:RESULT_BYTES]
    with running("sonar") as rig:
        with rig.accept() as client:
            assert received(client, FIRE_BYTES) == fire
            rig.say(wire.status("127.0.0.1", client="127.0.0.1"))
            rig.say(wire.status("127.0.0.9"))
            rig.say(b"no status")
            rig.wait(lambda: rig.counter("statuses") and rig.counter("other_statuses") and rig.counter("bad_status"))
            rig.wait(lambda: rig.pings, meanwhile=lambda: client.sendall(result[:100_000] + result))
            client.sendall(result[:90_000])  # cut off by the end of the connection
        with rig.accept() as client:
            assert received(client, FIRE_BYTES) == fire
            before = len(rig.pings)
            following = bytearray(result)
            following[53] ^= 0xFF  # the ping's number
            client.sendall(following)
            rig.wait(lambda: len(rig.pings) > before)
            rig.wait(lambda: rig.counter("port_losses") == 1)
            # silent now: given up after 2 s, and nobody takes the next connection
            rig.server.close()
            rig.wait(lambda: rig.says("connection refused"))
        rig.wait(
            lambda: rig.says("127.0.0.50 has its connection"),
            meanwhile=lambda: rig.say(wire.status("127.0.0.1", client="127.0.0.50")),
        )
        assert rig.counter("port_opens") == 2
