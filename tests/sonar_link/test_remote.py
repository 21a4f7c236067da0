"""Remote control of a sonar by the real process: `ods sonar` between a far end that obeys and planners on ZeroMQ."""

import socket
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgpack
import pytest
import tomli_w
import zmq

from ods.base import clock
from ods.cli import main
from ods.client import Sonar, SonarError, SonarRequest
from ods.messages import Health, Ping
from ods.runtime import bus
from ods.sim_sonar.device.lines.serial_line import SerialLine
from ods.sim_sonar.device.lines.tcp_line import FramedTcpLine
from ods.sim_sonar.device.remote_control_server import Line, RemoteControlServer
from ods.sim_sonar.sonar.model import load_sonar
from ods.sonar_link.s7k import records
from ods.sonar_link.setting_requests import Controls
from tests.sonar_link.sonar_samples import make_ping

pytestmark = pytest.mark.slow

CONFIG = Path(__file__).parents[2] / "config"
DR_M = 0.25
PERIOD_S = 0.05
PATIENCE_S = 20.0


class SimulatedSonar(threading.Thread):
    """Pings at a steady rate and does what it is reported; images are noise."""

    def __init__(self, line: Line) -> None:
        super().__init__(daemon=True)
        self.remote = RemoteControlServer(load_sonar(CONFIG / "sonars" / "seabat6012.toml"), line)
        self.line = line
        self.mute = False
        self.stubborn = False
        self._number = 0
        self._done = threading.Event()

    def run(self) -> None:
        while not self._done.wait(PERIOD_S):
            before = self.remote.controls
            self.remote.listen(clock.utc_ns())
            if self.stubborn:
                self.remote.controls = before
            controls = self.remote.controls
            self._number += 1
            ping = make_ping(self._number, samples=round(controls.range_m / DR_M), dr_m=DR_M, range0_m=DR_M)
            if not self.mute:
                self.line.write(self.remote.wanted(records.ping_records(ping, controls=controls)), 0.5)

    def restart(self) -> None:
        """Forget everything behind an open line, as after a power cut."""
        self.remote.controls = RemoteControlServer(
            load_sonar(CONFIG / "sonars" / "seabat6012.toml"), self.line
        ).controls

    def stop(self) -> None:
        self._done.set()
        self.join(5.0)
        self.line.unplug()


class Process:
    """`ods sonar` with a configuration file, and what it says."""

    def __init__(self, folder: Path, **sonar: Any) -> None:
        self.config, self.run_dir = folder / "onboard.toml", folder / "run"
        settings = tomllib.loads((CONFIG / "onboard.toml").read_text())
        settings["bus"]["run_dir"] = str(self.run_dir)
        settings["sonar"] = {"control_repeat_s": 0.3, "reopen_max_s": 0.2, **sonar}
        for name in ("ins_eds", "node_eds"):
            settings["nav"]["canopen"][name] = str(CONFIG / settings["nav"]["canopen"][name])
        self.config.write_text(tomli_w.dumps(settings))
        self.pings: list[Ping] = []
        self.health: Health | None = None
        self._popen = subprocess.Popen([sys.executable, "-m", "ods", "sonar", "--config", str(self.config)])
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._subscriber = bus.Subscriber(self._context, self.run_dir, ["ping"], ["sonar"])

    def wait(self, wanted: Callable[[], Any]) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < deadline, (self.health, len(self.pings))
            for topic, message in self._subscriber.receive(0.05)[0]:
                if topic == "ping":
                    self.pings.append(message)
                else:
                    self.health = message

    def range_m(self) -> float:
        ping = self.pings[-1] if self.pings else None
        return ping.samples * ping.dr_m if ping else 0.0

    def problems(self) -> list[str]:
        return self.health.problems if self.health else []

    def hears_again(self) -> None:
        """Take the next health report."""
        self.health = None
        self.wait(lambda: self.health)

    def close(self) -> None:
        self._popen.kill()
        self._popen.wait()
        self._subscriber.close()
        self._context.term()


@pytest.fixture
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="ods-") as name:  # a socket path must be short
        yield Path(name)


@pytest.fixture(params=["serial", "tcp"])
def far_end(request: pytest.FixtureRequest, folder: Path) -> Iterator[SimulatedSonar]:
    end = SimulatedSonar(FramedTcpLine(0) if request.param == "tcp" else SerialLine(folder / "seabat"))
    end.start()
    yield end
    end.stop()


@pytest.fixture
def start(folder: Path, far_end: SimulatedSonar) -> Iterator[Callable[..., Process]]:
    running = []

    def start(**sonar: Any) -> Process:
        line = far_end.line
        port = f"tcp://127.0.0.1:{line.port}" if isinstance(line, FramedTcpLine) else str(folder / "seabat")
        running.append(Process(folder, port=port, **sonar))
        return running[-1]

    yield start
    for process in running:
        process.close()


@pytest.fixture
def planner(folder: Path) -> Iterator[Sonar]:
    client = Sonar(folder / "run", timeout_s=10.0)
    yield client
    client.close()


def test_the_configured_range_is_set_and_set_again_after_reconnecting_and_after_a_restart_of_the_sonar(
    far_end: SimulatedSonar, start: Callable[..., Process]
) -> None:
    process = start(range_m=60.0, gain_db=12.0)
    process.wait(lambda: process.range_m() == 60.0)
    assert far_end.remote.controls == Controls(60.0, 210.0, 12.0)
    far_end.restart()
    process.wait(lambda: process.range_m() > 90.0)
    process.wait(lambda: process.range_m() == 60.0)
    far_end.line.unplug()
    process.wait(lambda: any("no ping for" in text for text in process.problems()))
    far_end.restart()
    far_end.line.plug()
    process.wait(lambda: far_end.remote.controls == Controls(60.0, 210.0, 12.0))
    process.wait(lambda: process.problems() == [] and process.range_m() == 60.0)


def test_a_sonar_is_left_alone_when_nothing_is_configured(
    far_end: SimulatedSonar, start: Callable[..., Process]
) -> None:
    process = start()
    process.wait(lambda: process.range_m() > 90.0 and process.health and process.health.ready)
    asked = 1 if isinstance(far_end.line, FramedTcpLine) else 0  # the subscription
    assert process.health is not None
    assert process.health.counters.get("control_requests", 0) == asked


def test_what_the_sonar_will_not_do_is_said_in_plain_words(
    far_end: SimulatedSonar, start: Callable[..., Process]
) -> None:
    process = start(range_m=900.0)
    process.wait(lambda: "the sonar refused range 900 m (error 2): it reports 100 m" in process.problems())
    process.wait(lambda: len(process.pings) > 3)  # it goes on


def test_a_planner_sets_the_range(far_end: SimulatedSonar, start: Callable[..., Process], planner: Sonar) -> None:
    process = start(range_m=80.0)
    process.wait(lambda: process.range_m() == 80.0)
    assert planner.set_range(50.0).range_m == 50.0
    process.wait(lambda: process.range_m() == 50.0)
    answer = planner.ask(SonarRequest(gain_db=20.0, power_db=200.0))
    assert (answer.range_m, answer.gain_db, answer.power_db) == (50.0, 20.0, 200.0)
    with pytest.raises(SonarError, match=r"the sonar refused range 500 m \(error 2\): it reports 50 m"):
        planner.set_range(500.0)
    far_end.stubborn = True
    with pytest.raises(SonarError, match="the sonar did not accept range 70 m: it reports 50 m"):
        planner.set_range(70.0)
    process.hears_again()
    assert process.problems() == []  # else all obstacle lists were not valid
    far_end.stubborn = False
    far_end.restart()
    process.wait(lambda: far_end.remote.controls == Controls(50.0, 200.0, 20.0))  # not what it refused
    far_end.mute = True
    with pytest.raises(SonarError, match="the sonar has been silent for"):
        planner.set_range(60.0)


def test_a_planner_needs_nothing_but_zmq_and_msgpack(far_end: SimulatedSonar, start: Callable[..., Process]) -> None:
    process = start()
    process.wait(lambda: process.pings)
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    request = context.socket(zmq.REQ)
    request.setsockopt(zmq.LINGER, 0)
    request.setsockopt(zmq.RCVTIMEO, 10_000)
    request.connect(f"ipc://{process.run_dir}/sonar-requests.sock")
    for body, ok, reason in (
        (msgpack.packb({"range_m": 40}), True, ""),
        (msgpack.packb({"range_m": -1.0}), False, "bad request: Expected `float` >= 0.1 - at `$.range_m`"),
        (msgpack.packb({"range_m": float("nan")}), False, "bad request"),
        (msgpack.packb({"range": 50.0}), False, "bad request: Object contains unknown field `range`"),
        (b"\xc1", False, "bad request"),
        (b"", False, "bad request"),
        (msgpack.packb({}), True, ""),
    ):
        request.send(body)
        answer = msgpack.unpackb(request.recv())
        assert answer["ok"] is ok, answer
        assert answer["reason"].startswith(reason)
    assert answer["range_m"] == 40.0
    process.wait(lambda: process.health and process.health.counters.get("bad_sonar-requests") == 5)
    context.destroy(linger=0)


def test_the_command_line_sets_and_shows(
    far_end: SimulatedSonar, start: Callable[..., Process], capsys: pytest.CaptureFixture[str]
) -> None:
    process = start()
    process.wait(lambda: process.pings)
    assert main(["set-sonar", "--range", "50", "--config", str(process.config)]) == 0
    assert main(["set-sonar", "--config", str(process.config)]) == 0
    assert capsys.readouterr().out == 2 * "the sonar reports: range 50.0 m, power 210.0 dB, gain 30.0 dB\n"
    assert main(["set-sonar", "--range", "500", "--config", str(process.config)]) == 2
    assert capsys.readouterr().err.startswith("ods set-sonar: the sonar refused range 500 m (error 2)")


def test_without_a_sonar_process_a_planner_is_reported_so_and_nothing_stays_behind(folder: Path) -> None:
    client = Sonar(folder, timeout_s=0.2)
    for _ in range(2):
        with pytest.raises(SonarError, match=r"no answer from the sonar process within 0.2 s: .* has no socket"):
            client.set_range(50.0)
    client.close()


def test_a_half_open_connection_is_made_again_by_the_process(folder: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(PATIENCE_S)
        process = Process(folder, port=f"tcp://127.0.0.1:{server.getsockname()[1]}", silence_s=0.5)
        first, _ = server.accept()  # and not a word
        second, _ = server.accept()
        process.wait(lambda: process.health and process.health.counters.get("port_losses", 0) >= 1)
        process.close()
        first.close()
        second.close()
