"""An INS that sends its clock first, with the highest identifier, on a bus, to the nav process and to doctor."""

import threading
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from ods.base import clock
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.doctor.navigation import listen
from ods.nav_bridge.settings import CanSettings
from tests.nav_bridge.handmade_ins import IDS, SIGNALS, data_of, number_of, settings
from tests.nav_bridge.nav_chain import nav_process

PERIOD_S = 0.04
ORDER = ("CLOCK", "PLACE", "DEPTH", "TURN", "SPEED")


@pytest.fixture
def can_settings() -> CanSettings:
    """python-can's virtual bus; tests/vcan has a real one."""
    return CanSettings(interface="virtual", channel="clock-first")


@pytest.fixture
def far(can_settings: CanSettings) -> Iterator[can.BusABC]:
    """The INS's end."""
    with can.Bus(can_settings.channel, can_settings.interface, ignore_config=True) as bus:
        yield bus


class Ins(threading.Thread):
    """Sends an instant every 40 ms until closed, and notes when."""

    def __init__(self, far: can.BusABC) -> None:
        super().__init__(daemon=True)
        self.sent_ns: list[int] = []
        self._far, self._stopping = far, threading.Event()

    def run(self) -> None:
        while not self._stopping.wait(PERIOD_S):
            now_ns = clock.monotonic_ns()
            self.sent_ns.append(now_ns)
            data = data_of(len(self.sent_ns) - 1, now_ns - self.sent_ns[0])
            for name in ORDER:
                self._far.send(can.Message(arbitration_id=IDS[name], data=data[name], is_extended_id=False))

    def close(self) -> None:
        self._stopping.set()
        self.join()


def test_each_pose_has_the_clock_of_its_own_instant(far: can.BusABC, can_settings: CanSettings, tmp_path: Path) -> None:
    dbc = settings(tmp_path, window_s=0.03)
    with nav_process(tmp_path, can_settings, dbc) as (_, client):
        ins = Ins(far)
        ins.start()
        client.until(lambda: len(client.poses) > 30)
        ins.close()
    for pose in client.poses:
        off_s = (pose.t_ns - ins.sent_ns[number_of(pose)]) / clock.NS
        assert abs(off_s) < PERIOD_S / 2


def test_a_wrong_order_is_refused_and_said(far: can.BusABC, can_settings: CanSettings, tmp_path: Path) -> None:
    dbc = settings(tmp_path, window_s=0.03, epoch=[*ORDER[1:], "CLOCK"])
    with nav_process(tmp_path, can_settings, dbc) as (_, client):
        ins = Ins(far)
        ins.start()
        client.until(lambda: client.says("epochs are paired wrongly by nav.dbc.epoch"))
        ins.close()
    assert client.poses == []


@pytest.mark.parametrize(("epoch", "wrong"), [("", False), (f"epoch = {[*ORDER[1:], 'CLOCK']}", True)])
def test_doctor_tells_a_wrong_order(
    far: can.BusABC, can_settings: CanSettings, tmp_path: Path, epoch: str, wrong: bool
) -> None:
    dbc = settings(tmp_path)
    signals = "\n".join(f'{field} = "{signal}"' for field, signal in SIGNALS.items())
    (tmp_path / "onboard.toml").write_text(f"""
[bus]
run_dir = "{tmp_path}"
[site]
latitude_deg = 57.0
longitude_deg = 9.9
[sonar]
port = "/dev/none"
[nav]
source = "dbc"
[nav.can]
interface = "{can_settings.interface}"
channel = "{can_settings.channel}"
[nav.dbc]
file = "{dbc.file}"
time = "CLOCK.US"
window_s = 0.03
{epoch}
[nav.dbc.signals]
{signals}
""")
    ins = Ins(far)
    ins.start()
    found = [item.text for item in listen(load(tmp_path / "onboard.toml", OnboardConfig), 1.5) if item.level == "wrong"]
    ins.close()
    assert any("epochs are paired wrongly" in text for text in found) == wrong
    assert all("epochs are paired wrongly" in text for text in found) or not wrong
