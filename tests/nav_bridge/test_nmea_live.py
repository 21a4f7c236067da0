"""An INS made by hand that speaks NMEA 0183 and PD6, on a real pseudo-terminal and by UDP: to nav, and to doctor."""

import itertools
import math
import os
import re
import socket
import threading
import tty
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median

import msgspec
import pytest

from ods.base import clock
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.doctor import navigation
from ods.doctor.lines import nav_line
from ods.doctor.navigation import NEVER, listen
from ods.messages import Pose
from ods.nav_bridge.settings import CanSettings, HeldSettings, NmeaSettings
from tests.nav_bridge.nav_chain import SITE, nav_process
from tests.nav_bridge.test_nmea import SPEED, USUAL, Ins

pytestmark = pytest.mark.slow

CONFIG = Path(__file__).parents[2] / "config"
PERIOD_S = 0.02
Write = Callable[[bytes], object]


class Vehicle(threading.Thread):
    """Sends attitude at 50 Hz, all else at 10 Hz, until closed; its clock is that of this machine."""

    def __init__(self, write: Write) -> None:
        super().__init__(daemon=True)
        self.begun_ns = clock.monotonic_ns()
        self.only: bytes | None = None
        self._write, self._stopping = write, threading.Event()

    def run(self) -> None:
        ins, count = Ins(), 0
        while not self._stopping.wait(PERIOD_S):
            t_ns = clock.monotonic_ns() - self.begun_ns
            sent = [ins.gga(t_ns), ins.gst(t_ns), ins.ts(t_ns), ins.bs(), ins.bd()] if count % 5 == 0 else []
            for line in [ins.pashr(t_ns), *sent]:
                self._write((self.only or line) + b"\r\n")
            count += 1

    def close(self) -> None:
        self._stopping.set()
        self.join()


@pytest.fixture(params=["pty", "udp"])
def ends(request: pytest.FixtureRequest) -> Iterator[tuple[str, Write]]:
    """`nav.nmea.port`, and what the INS writes with."""
    if request.param == "pty":
        master, slave = os.openpty()
        tty.setraw(slave)
        yield os.ttyname(slave), lambda data: os.write(master, data)
        os.close(master)
        os.close(slave)
        return
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        address = probe.getsockname()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as far:
        yield f"udp://127.0.0.1:{address[1]}", lambda data: far.sendto(data, address)


def check(poses: list[Pose], vehicle: Vehicle) -> None:
    """Assert that poses are where the vehicle was at their own instants; the first lines may wait on a busy machine."""
    off_m = []
    for pose in poses:
        assert pose.velocity_body == pytest.approx((SPEED, 0.0, 0.0))
        off_m.append(math.dist(pose.position_ned, Ins.place(pose.t_ns - vehicle.begun_ns)))
    assert median(off_m) < 0.02 * SPEED
    assert max(off_m) < 0.5 * SPEED


def test_sentences_become_poses_and_what_is_wrong_is_said(ends: tuple[str, Write], tmp_path: Path) -> None:
    port, write = ends
    nmea = msgspec.structs.replace(USUAL, port=port, held={"BS": HeldSettings(max_age_s=0.3)})
    with nav_process(tmp_path, CanSettings(), nmea=nmea) as (worker, client):
        client.until(lambda: client.says("no pose"))
        vehicle = Vehicle(write)
        vehicle.start()
        client.until(lambda: len(client.poses) > 50)
        check(client.poses, vehicle)
        client.until(lambda: not client.says(""))
        assert worker.ready()
        vehicle.only = b"$INGGA,garbled*00"
        client.until(lambda: client.says("BS: last came "))
        client.until(lambda: client.says("all useful sentences are damaged"))
        vehicle.only = None
        seen = len(client.poses)
        client.until(lambda: len(client.poses) > seen + 20)
        client.until(lambda: not client.says(""))
        vehicle.close()
        assert worker.service.counters["nmea_damaged"] > 10


def test_a_line_that_never_ends_is_reported_of(tmp_path: Path) -> None:
    """A broken wire, or another baud: zeros without an end."""
    master, slave = os.openpty()
    tty.setraw(slave)
    nmea = msgspec.structs.replace(USUAL, port=os.ttyname(slave))
    with nav_process(tmp_path, CanSettings(), nmea=nmea) as (_, client):
        client.until(lambda: client.says("no pose"))
        os.write(master, bytes(1000))
        client.until(lambda: client.says("the data received have no line ends: are nav.nmea.port, baud"))
        os.write(master, b"\n")
        client.until(lambda: not client.says("the data received have no line ends"))
    os.close(master)
    os.close(slave)


def test_datagrams_of_another_sender_are_not_taken(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        address = probe.getsockname()
    nmea = NmeaSettings(port=f"udp://127.0.0.1:{address[1]}", sender="127.0.0.2")
    with (
        nav_process(tmp_path, CanSettings(), nmea=nmea) as (worker, client),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as far,
    ):
        client.until(lambda: client.says("no pose"))
        for _ in range(5):
            far.sendto(Ins().gga(0) + b"\r\n", address)
        client.until(lambda: worker.service.counters["stranger_datagrams"] == 5)
        assert worker.service.counters["nmea_sentences"] == 0


def onboard(tmp_path: Path, port: str) -> OnboardConfig:
    text = (CONFIG / "onboard-nmea.toml").read_text().replace("[bus]", f'[bus]\nrun_dir = "{tmp_path}"')
    text = text.replace("57.0480", str(SITE.latitude_deg)).replace("9.9187", str(SITE.longitude_deg))
    file = tmp_path / "onboard.toml"
    file.write_text(text.replace("/dev/ttyUSB1", port))
    return load(file, OnboardConfig)


def test_doctor_looks_at_the_line_and_what_comes_on_it(ends: tuple[str, Write], tmp_path: Path) -> None:
    port, write = ends
    settings = onboard(tmp_path, port)
    found = {item.subject: item for item in (*nav_line.examine(settings.nav), *navigation.files(settings))}
    assert found[f"NMEA {port}"].level == ("note" if "://" in port else "good")
    assert found["navigation by nmea"].text == (
        "waits for BD (altitude), BS (velocity), GGA (place), GST (accuracy), PASHR (attitude, heading), TS (depth)"
    )
    vehicle = Vehicle(write)
    vehicle.start()
    findings = {item.subject: item for item in listen(settings, 1.5)}
    vehicle.only = Ins().pashr(0)
    missing = list(listen(settings, 1.0))
    vehicle.close()
    silent = list(listen(settings, 0.3))
    assert {item.level for item in findings.values()} == {"good"}
    assert "poses/s, the newest north" in findings["navigation by nmea"].text
    wrong = {item.subject: item.text for item in missing if item.level == "wrong"}
    assert wrong["NMEA GGA"] == "place: never came within 1 s: switch it on at the INS"
    assert wrong["navigation by nmea"].startswith("no pose for ")
    assert "; BS (velocity) has never come" in wrong["navigation by nmea"]
    assert [item.level for item in silent] == ["wrong"]
    right = "is nav.nmea.port right?" if "://" in port else "are nav.nmea.port and nav.nmea.baud right?"
    assert silent[0].text.endswith(right)
    assert NEVER not in silent[0].text


def test_doctor_says_what_is_lost_or_unusable_of_what_comes(ends: tuple[str, Write], tmp_path: Path) -> None:
    port, write = ends
    settings = onboard(tmp_path, port)
    pashr = itertools.count()

    def a_third_damaged(data: bytes) -> None:
        damaged = b"PASHR" in data and next(pashr) % 3 == 0
        write(data.replace(b"*", b"0*") if damaged else data)

    def gga_without_checksum(data: bytes) -> None:
        write(data.partition(b"*")[0] + b"\r\n" if b"GGA" in data else data)

    reported = []
    for writing in (a_third_damaged, gga_without_checksum):
        vehicle = Vehicle(writing)
        vehicle.start()
        reported.append({item.subject: item for item in reversed(list(listen(settings, 1.5)))})
        vehicle.close()
    assert reported[0]["navigation by nmea"].level == "note"
    assert re.search(r" deg: (2[5-9]|3\d|4[0-5])% of the INS's data is lost$", reported[0]["navigation by nmea"].text)
    assert reported[1]["NMEA GGA"].level == "wrong"
    assert "Hz, without checksum, and dropped" in reported[1]["NMEA GGA"].text
    assert reported[1]["NMEA PASHR"].level == "good"
    assert "GGA (place) comes without checksum" in reported[1]["navigation by nmea"].text


@pytest.mark.parametrize("ends", ["udp"], indirect=True)
def test_doctor_says_that_no_nmea_comes_without_asking_for_more(ends: tuple[str, Write], tmp_path: Path) -> None:
    port, write = ends
    vehicle = Vehicle(lambda data: write(b"\x81\x00\xff\n"))
    vehicle.start()
    (found,) = listen(onboard(tmp_path, port), 0.7)
    vehicle.close()
    assert found.level == "wrong"
    assert found.text == (
        "no expected data within 0.7 s: the data received are not NMEA: is nav.nmea.port right, "
        "and is what is sent there NMEA 0183?"
    )
