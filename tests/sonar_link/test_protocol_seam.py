"""The seam: every row of the table, and a made-up sonar through the real process over a real TCP socket."""

import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_type_hints

import pytest
import zmq

from ods.base.settings import Settings
from ods.client import Sonar, SonarError, SonarRequest
from ods.doctor.lines import sonar_port
from ods.messages import Health, Ping, SonarAnswer, frame_of
from ods.runtime import bus
from ods.sonar_link.protocol import SonarProtocol
from ods.sonar_link.registry import PROTOCOLS, ProtocolRow
from ods.sonar_link.settings import SonarSettings

ROOT = Path(__file__).parents[2]
PATIENCE_S = 20.0
PROGRAM = """
import sys
from pathlib import Path
from ods.runtime import service
from ods.runtime.processes import PROCESSES
from ods.sonar_link.registry import PROTOCOLS
from ods.sonar_link.service import SonarWorker
from ods.sonar_link.settings import SonarConfig, SonarSettings
from tests.sonar_link.lines_protocol import LinesProtocol
from tests.sonar_link.test_protocol_seam import LINES

PROTOCOLS["lines"] = LINES
LinesProtocol.udp_port = int(sys.argv[3])
sonar = SonarSettings(protocol="lines", port=sys.argv[2], range_m=30.0, reopen_max_s=0.2, control_repeat_s=0.3)
service.run_worker(SonarWorker, PROCESSES["sonar"], Path(sys.argv[1]), SonarConfig(sonar=sonar))
"""
LINES = ProtocolRow(
    "tests.sonar_link.lines_protocol:LinesProtocol", frozenset({"tcp"}), "none", "", frozenset({"range_m"})
)


@pytest.mark.parametrize("name", PROTOCOLS)
def test_every_row_is_whole(name: str) -> None:
    row = PROTOCOLS[name]
    assert issubclass(row.made_by, SonarProtocol)
    assert (ROOT / "docs" / "sonars" / row.page).is_file()
    assert f"| `{name}` | {row.sonars} |" in (ROOT / "docs" / "sonars" / "README.md").read_text()
    own = get_type_hints(SonarSettings).get(name)
    assert own is None or issubclass(own, Settings)


@pytest.mark.parametrize(
    ("sonar", "words"),
    [
        ({"protocol": "morse", "port": "/dev/seabat"}, "protocol: 'morse' is not one of s7k, "),
        ({"protocol": "lines", "port": "/dev/seabat"}, "port: /dev/seabat: lines works over tcp only"),
        ({"protocol": "lines", "port": "tcp://10.0.0.5:7", "gain_db": 10.0}, "gain_db: lines has its own settings"),
    ],
)
def test_what_a_protocol_cannot_do_is_one_line_that_names_the_key(
    sonar: dict[str, Any], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(PROTOCOLS, "lines", LINES)
    with pytest.raises(ValueError, match=f"^{words}"):
        SonarSettings(**sonar)


def test_a_process_loads_the_protocol_that_it_speaks_and_no_other() -> None:
    program = """
import sys
from collections import Counter
from ods.sonar_link import link, service
from ods.sonar_link.registry import make_protocol
from ods.sonar_link.settings import SonarSettings
make_protocol(SonarSettings(protocol="oculus", port="tcp://10.0.0.5:52100"), Counter())
print(*sorted(name for name in sys.modules if name.startswith("ods.sonar_link.s7k.")))
"""
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["ods.sonar_link.s7k.settings"]


class SimulatedSonar:
    """The sonar of lines: one client at a time, and the announcements."""

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self._server.settimeout(PATIENCE_S)
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("", 0))
            self.udp_port = probe.getsockname()[1]
        self.port = f"tcp://127.0.0.1:{self._server.getsockname()[1]}"
        self.client: socket.socket

    def accept(self) -> None:
        self.client, _ = self._server.accept()
        self.client.settimeout(PATIENCE_S)

    def line(self) -> bytes:
        """Return the next line that comes."""
        line = b""
        while not line.endswith(b"\n"):
            got = self.client.recv(1)
            assert got, "hung up"
            line += got
        return line

    def announce(self) -> None:
        self._udp.sendto(b"HERE lines-1", ("127.0.0.1", self.udp_port))

    def close(self) -> None:
        self._server.close()
        self._udp.close()


@pytest.fixture
def far_end() -> Iterator[SimulatedSonar]:
    end = SimulatedSonar()
    yield end
    end.close()


class Process:
    """A sonar process that speaks lines, and what it says."""

    def __init__(self, folder: Path, far_end: SimulatedSonar) -> None:
        self.pings: list[Ping] = []
        self.health: Health | None = None
        arguments = [str(folder), far_end.port, str(far_end.udp_port)]
        self._process = subprocess.Popen([sys.executable, "-c", PROGRAM, *arguments], cwd=ROOT)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._subscriber = bus.Subscriber(self._context, folder, ["ping"], ["sonar"])

    def wait(self, wanted: Callable[[], Any], meanwhile: Callable[[], object] = lambda: None) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < deadline, (self.health, len(self.pings))
            meanwhile()
            for topic, message in self._subscriber.receive(0.05)[0]:
                if topic == "ping":
                    self.pings.append(message)
                else:
                    self.health = message

    def says(self, problem: str) -> bool:
        return self.health is not None and problem in self.health.problems

    def counter(self, name: str) -> int:
        return self.health.counters.get(name, 0) if self.health else 0

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        self._subscriber.close()
        self._context.term()


@pytest.fixture
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="ods-") as name:  # a socket path must be short
        yield Path(name)


@pytest.fixture
def process(folder: Path, far_end: SimulatedSonar) -> Iterator[Process]:
    made = Process(folder, far_end)
    yield made
    made.close()


def asked(folder: Path, request: SonarRequest) -> tuple[threading.Thread, list[SonarAnswer | str]]:
    """Ask as a planner does, beside the test; the answer or the refusal comes into the list."""
    answers: list[SonarAnswer | str] = []

    def ask() -> None:
        client = Sonar(folder, timeout_s=PATIENCE_S)
        try:
            answers.append(client.ask(request))
        except SonarError as error:
            answers.append(str(error))
        client.close()

    thread = threading.Thread(target=ask)
    thread.start()
    return thread, answers


def test_another_sonar_speaks_through_the_real_process(process: Process, far_end: SimulatedSonar, folder: Path) -> None:
    far_end.accept()
    assert [far_end.line(), far_end.line()] == [b"HELLO\n", b"RANGE 30\n"]
    far_end.client.sendall(b"RANGE 30\n")

    def ping() -> None:
        far_end.client.sendall(b"PING 7 30 1 2 3\n")

    def ping_and_announce() -> None:
        ping()
        far_end.announce()

    process.wait(lambda: process.pings, meanwhile=ping)
    came = process.pings[-1]
    assert (came.ping_number, came.dr_m, came.range0_m, came.sound_speed) == (7, 10.0, 5.0, 1500.0)
    assert frame_of(came).tolist() == [[1, 2, 3]]
    assert came.t_ns == came.t_rx_ns
    assert came.utc_ns > 10**18

    # what it announces, beside the connection
    process.wait(lambda: process.says("the sonar has not announced itself"))
    process.wait(lambda: process.health and not process.health.problems, ping_and_announce)

    # a planner, as far as this sonar can be asked
    thread, answers = asked(folder, SonarRequest(range_m=50.0))
    assert far_end.line() == b"RANGE 50\n"
    far_end.client.sendall(b"RANGE 50\n")
    thread.join()
    assert answers == [SonarAnswer(ok=True, reason="", range_m=50.0)]
    thread, answers = asked(folder, SonarRequest(gain_db=10.0))
    thread.join()
    assert answers == ["gain_db: this sonar cannot be asked for its gain"]

    # noise, a connection that is lost in mid-line, and the next one
    far_end.client.sendall(b"noise\nPING 8 nan 1\nPING 9")
    process.wait(lambda: process.counter("bad_ping") == 2)
    far_end.client.close()
    far_end.accept()
    assert [far_end.line(), far_end.line()] == [b"HELLO\n", b"RANGE 50\n"]
    process.wait(lambda: process.counter("port_losses") == 1 and process.counter("garbage_bytes") == 6)
    process.pings.clear()
    process.wait(lambda: process.pings, meanwhile=ping)
    far_end.client.close()


@pytest.mark.parametrize(
    ("line", "level", "said"),
    [(b"PING 1 30 1 2 3\n", "good", " pings/s; "), (b"", "wrong", "no line within 0.5 s: is it switched on?")],
)
def test_the_doctor_listens_to_it(
    far_end: SimulatedSonar, folder: Path, monkeypatch: pytest.MonkeyPatch, line: bytes, level: str, said: str
) -> None:
    monkeypatch.setitem(PROTOCOLS, "lines", LINES)
    sonar = SonarSettings(protocol="lines", port=far_end.port, range_m=30.0)
    settings: Any = SimpleNamespace(bus=SimpleNamespace(run_dir=folder), sonar=sonar)
    received: list[bytes] = []

    def play() -> None:
        far_end.accept()
        received.append(far_end.line())
        far_end.client.sendall(line)
        received.append(far_end.client.recv(100))

    thread = threading.Thread(target=play)
    thread.start()
    (found,) = sonar_port.listen(settings, 0.5)
    thread.join()
    far_end.client.close()
    assert found.level == level
    assert said in found.text
    assert received == [b"HELLO\n", b""]  # listening changes no setting
