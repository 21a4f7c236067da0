"""The simulated Ping360 over a real pseudo-terminal and real datagrams: our link speaks with it, and so does brping."""

import math
import re
import socket
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from ods.base import clock
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.doctor.lines import sonar_port
from ods.messages import Ping, frame_of
from ods.runtime.bus import BusSettings
from ods.sim_sonar.device.lines.serial_line import SerialLine
from ods.sim_sonar.device.lines.udp_line import UdpLine
from ods.sim_sonar.device.live import Device, LiveSonar, Mission
from ods.sim_sonar.device.sonars.ping360 import SimulatedPing360
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.settings import SimSettings
from ods.sim_sonar.sonar.model import load_sonar
from ods.sonar_link.link import SonarLink
from ods.sonar_link.ping360 import messages
from ods.sonar_link.ping360.messages import Kind, Sweep, Transmission
from ods.sonar_link.ping360.settings import Ping360Settings
from ods.sonar_link.registry import make_protocol
from ods.sonar_link.settings import SonarSettings

CONFIG = Path(__file__).parents[2] / "config"
PATIENCE_S = 30.0
OWN = Ping360Settings(range_m=10.0, sector_deg=36.0, samples=400, ping_s=0.2)


class Sonar:
    """One that runs in a thread until the test ends."""

    def __init__(self, line: SerialLine | UdpLine) -> None:
        sim = SimSettings(CONFIG / "scenes/ping360.toml", CONFIG / "sonars/ping360.toml", ins_eds=CONFIG / "ins.eds")
        images = ImageSimulator(load_sonar(sim.sonar), load_scene(sim.scene))
        self.end = SimulatedPing360(images, line)
        self.live = LiveSonar(images, self.end, sim, Mission(clock.monotonic_ns(), []), line)
        self.device = Device("simulated sonar", self.live.step)
        self.line = line
        self.device.start()

    def close(self) -> None:
        self.device.stop()
        self.line.unplug()
        assert not self.device.failure


@pytest.fixture(params=["serial", "udp"])
def sonar(request: pytest.FixtureRequest) -> Iterator[tuple[Sonar, str]]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        if request.param == "serial":
            port = str(Path(folder) / "sonar")
            made = Sonar(SerialLine(Path(port)))
        else:
            line = UdpLine(0)
            port = f"udp://127.0.0.1:{line.port}"
            made = Sonar(line)
        try:
            yield made, port
        finally:
            made.close()


def pings_of(port: str, count: int) -> tuple[list[Ping], "Counter[str]"]:
    counters: Counter[str] = Counter()
    settings = SonarSettings(port, protocol="ping360", ping360=OWN, baud=115_200)
    link = SonarLink(settings, make_protocol(settings, counters), counters)
    pings: list[Ping] = []
    until_s = time.monotonic() + PATIENCE_S
    while len(pings) < count and time.monotonic() < until_s:
        pings += link.check(clock.monotonic_ns())
        pings += link.read(clock.monotonic_ns()) or []
        time.sleep(0.001)
    link.close(clock.monotonic_ns())
    return pings, counters


def test_our_link_makes_it_sweep_and_takes_its_beams(sonar: tuple[Sonar, str]) -> None:
    made, port = sonar
    pings, counters = pings_of(port, 16)
    assert len(pings) == 16
    assert made.end.controls == (OWN.transmission, OWN.sweep)
    assert not counters.keys() & {"garbage_bytes", "bad_checksum", "bad_ping", "control_lost", "port_losses"}
    assert counters["control_acknowledged"] == 1
    bearings = {round(math.degrees(bearing), 1) for ping in pings for bearing in ping.bearing_rad}
    assert bearings == {round(0.9 * step, 1) for step in range(-20, 21)}
    sweeps = [ping.sweep for ping in pings if ping.sweep is not None]
    assert {sweep.rising for sweep in sweeps} == {True, False}
    assert sum(sweep.ends for sweep in sweeps) >= 2
    times = sorted(t_ns for ping in pings for t_ns in ping.beam_t_ns)
    assert np.median(np.diff(times)) / clock.NS == pytest.approx(2 * 10.0 / 1500.0 + 0.0205, rel=0.2)
    assert {(ping.samples, ping.dtype) for ping in pings} == {(400, "u1")}


def test_the_doctor_makes_it_sweep_and_says_how_fast(sonar: tuple[Sonar, str]) -> None:
    _, port = sonar
    shipped = load(CONFIG / "onboard-ping360.toml", OnboardConfig)
    line = msgspec.structs.replace(shipped.sonar, port=port, ping360=OWN)
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        settings = msgspec.structs.replace(shipped, sonar=line, bus=BusSettings(run_dir=Path(folder)))
        found = list(sonar_port.listen(settings, 3.2))
    assert found[0].level == "good"
    assert "beams at" in found[0].text
    assert re.search(r"a sweep in 1\.[0-9] s", found[0].text)
    (before,) = sonar_port.examine(port) if port.startswith("udp") else [found[0]]
    assert before.level in ("note", "good")


def test_an_object_is_received_where_it_is(sonar: tuple[Sonar, str]) -> None:
    """The near sphere's face is 3.5 m away, right ahead; the vehicle hovers."""
    _, port = sonar
    pings, _ = pings_of(port, 8)
    rows: dict[int, list[Any]] = {}
    for ping in pings:
        for bearing, row in zip(ping.bearing_rad, frame_of(ping), strict=True):
            rows.setdefault(round(math.degrees(bearing) / 0.9), []).append(row.astype(float))
    ahead = np.mean(rows[0], axis=0)
    range_m = (1 + np.arange(400)) * pings[0].dr_m
    assert range_m[np.argmax(ahead)] == pytest.approx(3.8, abs=0.6)


def test_brping_makes_it_sweep_and_reads_its_beams(sonar: tuple[Sonar, str]) -> None:
    brping = pytest.importorskip("brping", reason="pip install bluerobotics-ping")
    _, port = sonar
    peer = brping.Ping360()
    if port.startswith("udp"):
        peer.connect_udp("127.0.0.1", int(port.rpartition(":")[2]))
    else:
        peer.connect_serial(port, 115200)
    assert peer.initialize()
    asked = OWN.transmission
    peer.control_auto_transmit(1, *asked, *OWN.sweep)
    angles = []
    for _ in range(60):
        message = peer.wait_message([brping.definitions.PING360_AUTO_DEVICE_DATA], 5.0)
        assert message
        assert (message.sample_period, message.number_of_samples) == (asked.period, asked.samples)
        assert len(message.data) == asked.samples
        angles.append((message.angle + 200) % 400 - 200)
    assert angles[:41] == list(range(-20, 21))
    assert angles[41:] == list(range(19, 0, -1))
    peer.iodev.close()


@pytest.mark.parametrize(
    ("asked", "sweep", "answer"),
    [
        (OWN.transmission, OWN.sweep, Kind.ACK),
        (OWN.transmission._replace(samples=1201), OWN.sweep, Kind.NACK),
        (OWN.transmission, OWN.sweep._replace(stop=400), Kind.NACK),
        (OWN.transmission, OWN.sweep._replace(steps=0), Kind.NACK),
    ],
)
def test_it_refuses_what_it_cannot(asked: Transmission, sweep: Sweep, answer: Kind) -> None:
    line = UdpLine(0)
    images = ImageSimulator(load_sonar(CONFIG / "sonars/ping360.toml"), load_scene(CONFIG / "scenes/ping360.toml"))
    end = SimulatedPing360(images, line)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.settimeout(PATIENCE_S)
        peer.connect(("127.0.0.1", line.port))
        peer.send(b"noise" + messages.auto_transmit(asked, sweep))
        end.listen(0)
        said = peer.recv(4096)
    line.unplug()
    assert (messages.unpack_header(said).kind, messages.decode_id(said)) == (answer, Kind.AUTO_TRANSMIT)
    assert end.controls == ((asked, sweep) if answer == Kind.ACK else None)
