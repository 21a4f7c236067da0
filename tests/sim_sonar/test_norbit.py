"""The simulated Norbit, read at the places of TN-180196, by no codec of the program."""

import binascii
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
from ods.sim_sonar.device.sonars.norbit import SimulatedNorbit
from ods.sim_sonar.device.sonars.norbit_packets import to_samples
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.sonar.model import make_sonar
from ods.sim_sonar.sonar.settings import SonarFile

CONFIG = Path(__file__).parents[2] / "config"
PATIENCE_S = 10.0
SECOND = 1_000_000_000


class Client:
    """Both ends: the simulated sonar, and who talks to it."""

    def __init__(self) -> None:
        file = load(CONFIG / "sonars" / "norbit_wbms_fls.toml", SonarFile)
        file = msgspec.structs.replace(file, beams_per_plane=16, beam_spacing_deg=8.0, samples=50, dr_m=0.8)
        self.nominal = ImageSimulator(make_sonar(file), load_scene(CONFIG / "scenes" / "figure11.toml"))
        self.line, self.commands = TcpLine(0), TcpLine(0)
        self.end = SimulatedNorbit(self.nominal, self.line, self.commands)
        self.images = socket.create_connection(("127.0.0.1", self.line.port), PATIENCE_S)
        self.socket = socket.create_connection(("127.0.0.1", self.commands.port), PATIENCE_S)
        self.ask("", 2)

    def ask(self, words: str, lines: int = 1) -> str:
        """Send a command, let the sonar receive it, return its answer."""
        self.socket.sendall(words.encode() + b"\r\n")
        self.socket.setblocking(False)
        got, deadline = b"", time.monotonic() + PATIENCE_S
        while got.count(b"\n") < lines and time.monotonic() < deadline:
            self.end.listen(SECOND)
            try:
                got += self.socket.recv(4096)
            except BlockingIOError:
                continue
        return got.decode().strip()

    def ping(self, number: int = 7) -> list[bytes]:
        """Return what the next ping sends."""
        return self.end.wanted(self.end.telegram(self.end.images(), 0.0, number, 0, 5 * SECOND))

    def close(self) -> None:
        self.line.unplug()
        self.end.close()
        self.images.close()
        self.socket.close()


@pytest.fixture
def client() -> Iterator[Client]:
    made = Client()
    yield made
    made.close()


def read(data: bytes, code: str, place: int) -> float:
    return float(struct.unpack_from(f"<{code}", data, place)[0])


def test_it_answers_with_the_values_that_hold(client: Client) -> None:
    assert client.ask("set_range") == "set_range 0 50 # simulated"
    assert client.ask("set_range 0 20") == "set_range 0 20 # simulated"
    assert client.ask("set_range 0 9000") == "set_range 0 20 # simulated"
    assert client.ask("set_range 0 nan") == "set_range 0 20 # simulated"
    assert client.ask("set_resolution 500 100") == "set_resolution 256 128 # simulated"
    assert client.ask("set_power on") == "set_power: arguments are numbers"
    assert client.ask("fire") == "fire: unknown command"


def test_it_pings_only_when_asked_to_and_its_packet_is_that_of_the_document(client: Client) -> None:
    assert client.ping() == []
    for words in ["set_mode 0", "set_range 0 20", "set_opening_angle 90", "set_resolution 400 64", "set_rate 4",
                  "set_tx 300 60 9 200", "set_vga 0", "set_gain 6", "sound_velocity 1450", "set_power 1"]:  # fmt: skip
        client.ask(words)
    (data,) = client.ping(8)
    assert data[:8] == bytes.fromhex("efbeadde02000000")
    assert (read(data, "I", 8), read(data, "I", 12)) == (len(data), 4)
    assert read(data, "I", 20) == binascii.crc32(data[24:])
    beams, samples = int(read(data, "I", 32)), int(read(data, "I", 36))
    assert beams == 64
    assert len(data) == 192 + 2 * beams * samples + 4 * beams
    assert read(data, "f", 24) == 1450.0
    spacing_m = 1500.0 / (2 * read(data, "f", 28))
    assert (read(data, "i", 52) + samples - 1) * spacing_m == pytest.approx(20.0, abs=spacing_m)
    assert samples <= 400
    assert (read(data, "d", 40), read(data, "I", 48), read(data, "I", 108)) == (5.0, 2, 8)
    assert [read(data, "f", place) for place in (72, 76)] == [300.0, 60.0]
    assert (read(data, "I", 84), read(data, "f", 100), data[153]) == (9, 4.0, 0)
    assert [read(data, "f", 128), read(data, "f", 136)] == [6.0, 6.0]
    bearings = np.degrees(np.frombuffer(data, "<f4", beams, 192 + 2 * beams * samples))
    assert bearings[[0, 63]] == pytest.approx([-44.3, 44.3], abs=0.05)


def test_samples_are_one_range_after_another_at_a_share_of_the_full_scale(client: Client) -> None:
    assert to_samples(np.array([[0.0, 50.0, 100.0, 200.0]], np.float32), 100.0).tolist() == [[0, 32768, 65535, 65535]]
    client.ask("set_resolution 64 64")
    client.ask("set_power 1")
    images = client.end.images()
    (data,) = client.end.telegram(images, 0.0, 3, 0, SECOND)
    beams, samples = images.sonar.beams, images.sonar.samples
    sent = np.frombuffer(data, "<u2", beams * samples, 192).reshape(samples, beams)
    full_scale = client.nominal.scene.file.image.full_scale_counts
    np.testing.assert_array_equal(sent.T, to_samples(images.render(0.0, 3), full_scale))
