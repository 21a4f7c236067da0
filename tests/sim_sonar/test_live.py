"""The live simulated SeaBat: it obeys remote control from the next ping on, on a serial line and over TCP."""

import socket
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from ods.base import clock
from ods.base.arrays import Floats
from ods.messages import Ping, frame_of
from ods.sim_sonar.device.lines.tcp_line import FramedTcpLine
from ods.sim_sonar.device.live import LiveSonar, Mission
from ods.sim_sonar.device.remote_control_server import LEAST_RANGE_M, RemoteControlServer
from ods.sim_sonar.device.sonars.seabat import SimulatedSeaBat
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.settings import SimSettings
from ods.sim_sonar.sonar.model import SonarModel, load_sonar
from ods.sonar_link.s7k import records, remote_control
from ods.sonar_link.s7k.assembler import Assembler
from ods.sonar_link.s7k.drf import S7kRecord
from ods.sonar_link.s7k.framer import RecordFramer
from ods.sonar_link.s7k.network_frame import Deframer, frame_record
from ods.sonar_link.s7k.remote_control import ControlRequest
from ods.sonar_link.setting_requests import Controls

CONFIG = Path(__file__).parents[2] / "config"
SCENE, SONAR = CONFIG / "scenes" / "figure11.toml", CONFIG / "sonars" / "seabat6012.toml"


class Wire:
    """A serial line that keeps what is sent and gives what a test asks for."""

    needs_subscription = False
    connections = 0
    lost_bytes = 0

    def __init__(self) -> None:
        self.sent: list[S7kRecord] = []
        self.asked = b""

    def plug(self) -> None: ...

    def unplug(self) -> None: ...

    def write(self, records: list[bytes], patience_s: float) -> bool:
        self.sent += RecordFramer().feed(b"".join(records))
        return True

    def read(self) -> bytes:
        data, self.asked = self.asked, b""
        return data

    def ask(self, command: int, value: float) -> None:
        request = remote_control.set_value(command, 5, value)
        self.asked += remote_control.encode_request(request, clock.utc_ns(), records.DEVICE)


@pytest.fixture(scope="module")
def sonar() -> SonarModel:
    return load_sonar(SONAR)


class PunctualSonar(LiveSonar):
    """Each step comes just when it is due, however long the last one took: the clock is the test's."""

    def __init__(self, images: ImageSimulator, wire: Wire, patch: pytest.MonkeyPatch) -> None:
        self._now_ns = self._due_ns = 100 * clock.NS
        patch.setattr(clock, "monotonic_ns", lambda: self._now_ns)
        settings = SimSettings(scene=SCENE, sonar=SONAR, ins_eds=CONFIG / "ins.eds")
        super().__init__(images, SimulatedSeaBat(images, wire), settings, Mission(self._now_ns, []), wire)
        self._due_ns = super().step()

    def step(self) -> int:
        self._now_ns = self._due_ns
        self._due_ns = super().step()
        return self._due_ns


@pytest.fixture
def live(sonar: SonarModel, monkeypatch: pytest.MonkeyPatch) -> tuple[LiveSonar, Wire]:
    """A sonar that pings at each step."""
    wire = Wire()
    return PunctualSonar(ImageSimulator(sonar, load_scene(SCENE)), wire, monkeypatch), wire


def pings_of(wire: Wire) -> list[Ping]:
    assembler = Assembler()
    return [ping for record in wire.sent if (ping := assembler.feed(record, records.decode(record))) is not None]


def told_by(wire: Wire) -> list[Controls]:
    decoded = [records.decode(record) for record in wire.sent if record.record_type == records.SONAR_SETTINGS]
    return [item.controls for item in decoded if isinstance(item, records.SettingsRecord)]


def replies_of(wire: Wire) -> list[remote_control.ControlReply]:
    kinds = (remote_control.ACKNOWLEDGED, remote_control.REFUSED)
    return [remote_control.decode_reply(record) for record in wire.sent if record.record_type in kinds]


def test_the_range_changes_at_the_next_ping_with_the_same_spacing_and_a_shorter_period(
    live: tuple[LiveSonar, Wire],
) -> None:
    seabat, wire = live
    first = seabat.step()
    wire.ask(remote_control.SET_RANGE, 50.0)
    second = seabat.step()
    third = seabat.step()
    assert replies_of(wire) == [remote_control.ControlReply(5, None)]
    pings = pings_of(wire)
    assert [p.samples for p in pings] == [2000, 2000, 1000]
    assert [p.dr_m for p in pings] == pytest.approx([0.05] * 3)
    assert [c.range_m for c in told_by(wire)] == [100.0, 100.0, 50.0]
    # from one last echo to the next: 16 ms of overhead, and the way out and back at 1500 m/s
    assert (third - second) / 1e9 == pytest.approx(0.016 + 2 * 50.0 / 1500.0, abs=1e-6)
    assert second > first
    truths = [seabat.truths.get_nowait() for _ in range(3)]
    farthest = [max(np.hypot(*o.position_ned[:2]) for o in t.objects if o.in_sector) for t in truths]
    assert farthest[0] > 70.0
    assert farthest[2] < 50.0


def test_gain_raises_everything_power_the_echoes_only(sonar: SonarModel) -> None:
    scene = load_scene(SCENE)

    def mean(power_db: float = 0.0, gain_db: float = 0.0) -> Floats:
        images = ImageSimulator(sonar, scene, power_db=power_db, gain_db=gain_db)
        return images.mean_image(0.0).astype(np.float64)

    plain, gained, powered = mean(), mean(gain_db=6.0), mean(power_db=6.0)
    factor = 10 ** (6 / 20)
    free = gained < 0.9 * gained.max()  # below saturation
    np.testing.assert_allclose(gained[free], factor * plain[free], rtol=1e-4)
    noise = plain.min()
    np.testing.assert_allclose(
        (powered**2 - noise**2)[free], (factor**2 * (plain**2 - noise**2))[free], rtol=1e-3, atol=1e-2 * noise**2
    )


def test_gain_shows_in_the_samples_and_in_the_settings(live: tuple[LiveSonar, Wire]) -> None:
    seabat, wire = live
    wire.ask(remote_control.SET_GAIN, 40.0)
    for _ in range(2):
        seabat.step()
    before, after = (frame_of(ping).astype(float) for ping in pings_of(wire))
    assert [c.gain_db for c in told_by(wire)] == [30.0, 40.0]
    assert np.median(after) - np.median(before) == pytest.approx(40 * 10 / 20, abs=2.0)  # 40 levels a decade


@pytest.mark.parametrize(
    ("command", "value", "error"),
    [
        (remote_control.SET_RANGE, 100.0, None),
        (remote_control.SET_RANGE, 100.1, 2),
        (remote_control.SET_RANGE, LEAST_RANGE_M - 0.1, 2),
        (remote_control.SET_POWER, 230.0, 2),
        (remote_control.SET_GAIN, -1.0, 2),
        (1006, 1e-4, 1),
    ],
)
def test_what_is_out_of_its_limits_is_refused(sonar: SonarModel, command: int, value: float, error: int | None) -> None:
    wire = Wire()
    end = RemoteControlServer(sonar, wire)
    before = end.controls
    wire.ask(command, value)
    end.listen(clock.utc_ns())
    assert replies_of(wire) == [remote_control.ControlReply(5, error)]
    assert end.controls == before


def test_broken_requests_are_ignored(sonar: SonarModel) -> None:
    wire = Wire()
    end = RemoteControlServer(sonar, wire)
    wire.ask(remote_control.SET_RANGE, float("nan"))
    broken = ControlRequest(remote_control.SET_GAIN, 1, b"\0")
    wire.asked += remote_control.encode_request(broken, clock.utc_ns(), records.DEVICE)
    wire.asked += b"garbage"
    end.listen(clock.utc_ns())
    assert (wire.sent, end.controls.range_m) == ([], 100.0)


@pytest.fixture
def line() -> Iterator[FramedTcpLine]:
    made = FramedTcpLine(0)
    yield made
    made.unplug()


def test_over_tcp_only_what_was_subscribed_to_comes_and_a_new_client_begins_afresh(
    sonar: SonarModel, line: FramedTcpLine
) -> None:
    end = RemoteControlServer(sonar, line)
    sent = records.ping_records(ImageSimulator(sonar, load_scene(SCENE)).ping(0.0, 1, 0, clock.utc_ns()))
    assert end.wanted(sent) == []
    client = socket.create_connection(("127.0.0.1", line.port))
    client.settimeout(10.0)
    request = remote_control.encode_request(remote_control.subscribe(1, [7000, 7042]), clock.utc_ns(), records.DEVICE)
    client.sendall(frame_record(request, 1))
    while not end.wanted(sent):
        end.listen(clock.utc_ns())
    assert line.write(end.wanted(sent), 1.0)
    deframer, framer = Deframer(1 << 22), RecordFramer()
    types: list[int] = []
    while len(types) < 3:
        types += [record.record_type for record in framer.feed(deframer.feed(client.recv(1 << 16)))]
    assert types == [7501, 7000, 7042]
    assert deframer.counters["network_frames"] == 1 + 1 + 3  # 120 kB in packets of 60 kB
    client.close()
    while line.connections < 2:
        with socket.create_connection(("127.0.0.1", line.port)):
            end.listen(clock.utc_ns())
    assert end.wanted(sent) == []
