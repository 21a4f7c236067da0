"""The simulated Oculus, read at the places of the maker's structures, by no codec of the program."""

import socket
import struct
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest

from ods.base.settings_file import load
from ods.sim_sonar.device.lines.tcp_line import TcpLine
from ods.sim_sonar.device.sonars import oculus_messages
from ods.sim_sonar.device.sonars.oculus import SimulatedOculus
from ods.sim_sonar.device.sonars.oculus_messages import to_samples
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.sonar.model import make_sonar
from ods.sim_sonar.sonar.settings import SonarFile
from tests.sonar_link.oculus import wire

CONFIG = Path(__file__).parents[2] / "config"
PATIENCE_S = 10.0
SECOND = 1_000_000_000


class Client:
    """Both ends: the simulated sonar, and who talks to it."""

    def __init__(self) -> None:
        file = load(CONFIG / "sonars" / "oculus_m750d.toml", SonarFile)
        file = msgspec.structs.replace(file, beams_per_plane=16, beam_spacing_deg=8.0, samples=200, dr_m=0.2)
        scene = load_scene(CONFIG / "scenes" / "figure11.toml")
        self.statuses = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.statuses.bind(("127.0.0.1", 0))
        self.statuses.settimeout(PATIENCE_S)
        self.line = TcpLine(0)
        nominal = ImageSimulator(make_sonar(file), scene)
        self.end = SimulatedOculus(file, nominal, self.line, self.statuses.getsockname()[1])
        self.socket = socket.create_connection(("127.0.0.1", self.line.port), PATIENCE_S)
        self.now_ns = SECOND

    def ask(self, version: int = 2, extended: int = 0, **fields: float) -> None:
        """Send a fire message and let the sonar receive it."""
        data = wire.header(0x15, 89 if version == 2 else 53, version, source=0)
        wire.put_fire(data, **fields)
        if version == 2:
            struct.pack_into("<I", data, 53, extended)
        before = self.end.controls
        self.socket.sendall(data)
        deadline = time.monotonic() + PATIENCE_S
        while self.end.controls is before and time.monotonic() < deadline:
            self.end.listen(self.now_ns)

    def ping(self, number: int = 7) -> bytes:
        """Return the next ping result."""
        (result,) = self.end.telegram(self.end.images(), 0.0, number, 0, self.now_ns)
        return result

    def close(self) -> None:
        self.line.unplug()
        self.socket.close()
        self.statuses.close()
        self.end.close()


@pytest.fixture
def client() -> Iterator[Client]:
    made = Client()
    yield made
    made.close()


def read(data: bytes, code: str, place: int) -> float:
    return float(struct.unpack_from(f"<{code}", data, place)[0])


def test_a_result_of_the_second_version_at_its_places(client: Client) -> None:
    client.ask(range=20.0, gain=50.0, gamma=127, flags=0x49, salinity=35.0)
    client.now_ns += 5 * SECOND
    first = client.ping()
    client.now_ns += SECOND
    data = client.ping(8)
    assert (data[:2], data[6:10], read(data, "I", 10)) == (b"SO", bytes([0x23, 0, 2, 0]), len(data) - 16)
    assert (data[16], data[19], data[20]) == (1, 127, 0x49)
    assert [read(data, "d", place) for place in (21, 29, 45)] == [20.0, 50.0, 35.0]
    assert (read(data, "I", 89), read(data, "d", 97), read(data, "d", 145)) == (8, 750e3, 1500.0)
    assert read(data, "d", 153) - read(first, "d", 153) == pytest.approx(1.0)
    assert (data[161], read(data, "d", 162), read(data, "H", 170), read(data, "H", 172)) == (0, 0.2, 101, 16)
    assert [read(data, "I", place) for place in (190, 194, 198)] == [234, 16 * 101, len(data)]
    bearings = np.frombuffer(data, "<i2", 16, 202)
    assert bearings.tolist() == [800 * beam - 6000 for beam in range(16)]


def test_a_result_of_the_first_version_with_16_bits(client: Client) -> None:
    client.ask(1, range=10.0, flags=0x4B)
    data = client.ping()
    assert (data[8:10], read(data, "I", 53)) == (bytes([1, 0]), 7)
    assert (data[97], read(data, "d", 98), read(data, "H", 106), read(data, "H", 108)) == (1, 0.2, 51, 16)
    assert [read(data, "I", place) for place in (110, 114, 118)] == [154, 2 * 16 * 51, len(data)]


def test_32_bits_gains_and_256_beams(client: Client) -> None:
    client.ask(range=10.0, flags=0x0F, extended=0x200)
    data = client.ping()
    assert (data[161], read(data, "H", 172)) == (3, 8)  # half the beams of this small sonar
    assert read(data, "I", 194) == 51 * (4 + 4 * 8)


def test_the_high_mode_is_narrower_and_tells_another_gain(client: Client) -> None:
    client.ask(mode=2, range=20.0, gain=50.0)
    data = client.ping()
    assert [data[16], read(data, "d", 29), read(data, "d", 97)] == pytest.approx([2, 70.0, 1.2e6])
    assert np.frombuffer(data, "<i2", 16, 202)[-1] == round(6000 * 70 / 130)


def test_gain_raises_the_samples(client: Client) -> None:
    client.ask(range=20.0, gain=50.0, flags=0x4B)
    quiet = np.frombuffer(client.ping(), "<u2", offset=234).astype(float)
    client.ask(range=20.0, gain=62.0, flags=0x4B)
    loud = np.frombuffer(client.ping(), "<u2", offset=234).astype(float)
    inside = (quiet > 50) & (loud < 65535)
    assert inside.sum() > 20
    assert np.median(loud[inside] / quiet[inside]) == pytest.approx(10 ** (6 / 20), rel=0.03)


def test_a_sound_speed_that_is_reported_stretches_the_ranges(client: Client) -> None:
    client.ask(range=20.0, sound=1530.0)
    data = client.ping()
    assert [read(data, "d", 145), read(data, "d", 162)] == pytest.approx([1530.0, 0.2 * 1530 / 1500])


@pytest.mark.parametrize(("rate", "range_m", "period_s"), [(0, 20.0, 0.1), (1, 20.0, 1 / 15), (2, 40.0, 0.0582)])
def test_the_rate_is_the_asked_one_or_what_the_range_takes(
    client: Client, rate: int, range_m: float, period_s: float
) -> None:
    client.ask(rate=rate, range=range_m)
    assert client.end.period_s(client.end.images().sonar) == pytest.approx(period_s, rel=0.01)


def test_standby_sends_dummies_and_the_status_tells_who_is_connected(client: Client) -> None:
    client.end.listen(client.now_ns)
    client.end.listen(client.now_ns + SECOND)
    assert client.socket.recv(100)[6] == 0xFF
    client.statuses.recv(1000)
    status = client.statuses.recv(1000)
    assert (len(status), status[:2], read(status, "H", 22)) == (142, b"SO", 1032)
    assert (status[52:56], status[60:64]) == (bytes([127, 0, 0, 1]), bytes([127, 0, 0, 1]))
    assert client.end.telegram(client.end.images(), 0.0, 1, 0, client.now_ns) == []


@pytest.mark.parametrize("fields", [{"mode": 3}, {"range": float("nan")}, {"range": 0.0}, {"gain": float("inf")}])
def test_what_it_cannot_do_it_does_not(client: Client, fields: dict[str, float]) -> None:
    data = wire.header(0x15, 53, 1)
    wire.put_fire(data, **fields)
    client.socket.sendall(data)
    client.ask(range=12.0)
    assert client.end.controls is not None
    assert client.end.controls.range_m == 12.0


def test_requests_come_in_pieces_and_foreign_ones_are_skipped() -> None:
    fire = wire.header(0x15, 53, 1)
    wire.put_fire(fire)
    stream = bytearray(wire.header(0x55, 28) + fire[:30])
    assert oculus_messages.take_fire(stream) is None
    stream += fire[30:]
    taken = oculus_messages.take_fire(stream)
    assert taken is not None
    assert (taken.range_m, len(stream)) == (40.0, 0)


def test_samples_are_the_power_of_the_amplitude() -> None:
    amplitude = np.array([[0.0, 25.0, 100.0, 400.0]], np.float32)
    assert to_samples(amplitude, 100.0, 1, 255).tolist() == [[0, 64, 255, 255]]
    assert to_samples(amplitude, 100.0, 1, 127).tolist() == [[0, round(255 * 0.25 ** (127 / 255)), 255, 255]]
    assert to_samples(amplitude, 100.0, 2, 0).tolist() == [[0, 16384, 65535, 65535]]
    assert to_samples(amplitude, 100.0, 4, 255).tolist() == [[0, 2**30, 2**32 - 1, 2**32 - 1]]
