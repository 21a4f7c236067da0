"""The simulated INSs tell the height over the scene's bed: through their lines and `ods nav`, as on the bench."""

import difflib
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import msgspec
import numpy as np
import pytest
from can.interfaces.slcan import slcanBus

from ods.base import clock
from ods.base.geodesy import LocalFrame
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.messages import Pose
from ods.nav_bridge.settings import CanSettings, NavSettings
from ods.sim_sonar.device.lines.serial_line import SerialLine
from ods.sim_sonar.device.live import Device, LiveIns, Mission
from ods.sim_sonar.ins.canopen_ins import SimulatedIns
from ods.sim_sonar.ins.dbc_ins import SimulatedDbcIns
from ods.sim_sonar.ins.nmea_ins import SimulatedNmeaIns
from ods.sim_sonar.ins.place import InsPlace
from ods.sim_sonar.ins.sigmas import USUAL_SIGMAS
from ods.sim_sonar.ins.slcan_hub import SlcanHub
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.settings import SimSettings
from tests.nav_bridge.nav_chain import CONFIG, SITE, Client, nav_process

Ins = SimulatedIns | SimulatedDbcIns | SimulatedNmeaIns
FRAME = LocalFrame(SITE.latitude_deg, SITE.longitude_deg)
SLOPE, NO_BED = CONFIG / "scenes" / "sea" / "slope.toml", CONFIG / "scenes" / "empty.toml"


@contextmanager
def flying(file: Path, ins: Ins) -> Iterator[tuple[Scene, Mission]]:
    """The simulated vehicle under way, which tells where it is."""
    scene = load_scene(file)
    mission = Mission(clock.monotonic_ns(), [])
    settings = SimSettings(scene=file, sonar=CONFIG / "sonars" / "seabat6012.toml", ins="nmea")
    device = Device("simulated INS", LiveIns(scene, settings, mission, ins, InsPlace(FRAME)).step)
    device.start()
    try:
        yield scene, mission
    finally:
        device.stop()
        assert not device.failure


@contextmanager
def on_can(folder: Path, nav: NavSettings, make: Callable[[slcanBus], Ins]) -> Iterator[tuple[Client, Ins]]:
    """The nav process and an INS on a bus of pseudo-terminals."""
    with ExitStack() as stack:
        hub = stack.enter_context(SlcanHub([folder / "can0", folder / "can1"]))
        far = slcanBus(str(hub.links[1]), sleep_after_open=0.0, timeout=0.0)
        stack.callback(far.shutdown)
        near = CanSettings(interface="slcan", channel=str(hub.links[0]), bitrate=500_000)
        _, client = stack.enter_context(nav_process(folder, near, nav.dbc, canopen=nav.canopen))
        yield client, make(far)


def check(client: Client, scene: Scene, mission: Mission) -> None:
    """Assert that poses have the height over the bed where they are, with the noise that is reported."""
    client.until(lambda: sum(pose.altitude_m is not None for pose in client.poses) > 60)
    bed = scene.sea_bed
    assert bed is not None
    off = [
        pose.altitude_m - bed.altitude_of(scene.vehicle_at(mission.seconds(pose.t_ns)).position_ned)
        for pose in client.poses
        if pose.altitude_m is not None
    ]
    assert abs(np.mean(off)) < 0.1
    assert 0.5 * USUAL_SIGMAS.over_bottom < np.std(off) < 2.0 * USUAL_SIGMAS.over_bottom


def never(client: Client) -> list[Pose]:
    """Return poses of a while, none of which has an altitude, and of which none is lost."""
    client.until(lambda: len(client.poses) > 60)
    client.until(lambda: client.health is not None)
    assert client.health is not None
    assert not client.health.counters.get("altitude_absurd", 0)
    assert all(pose.altitude_m is None for pose in client.poses)
    return client.poses


@pytest.mark.parametrize("file", ["onboard-altitude.toml", "onboard.toml"])
@pytest.mark.parametrize("scene_file", [SLOPE, NO_BED])
def test_an_ins_by_canopen(tmp_path: Path, file: str, scene_file: Path) -> None:
    nav = load(CONFIG / file, OnboardConfig).nav
    assert nav.canopen is not None
    eds = nav.canopen.ins_eds
    with (
        on_can(tmp_path, nav, lambda bus: SimulatedIns(bus, eds)) as (client, ins),
        flying(scene_file, ins) as flight,
    ):
        if scene_file == SLOPE and file == "onboard-altitude.toml":
            check(client, *flight)
        else:
            assert never(client)


def test_an_altimeter_beside_an_ins_by_dbc_as_the_example_says(tmp_path: Path) -> None:
    text = (CONFIG / "onboard-sbg.toml").read_text().replace('"sbg.dbc"', f'"{CONFIG / "sbg.dbc"}"')
    with_it = re.sub(r"^# (over_bottom|\[nav|\[\[nav|max_age_s|signal|accept|says)", r"\1", text, flags=re.MULTILINE)
    assert with_it.count("ALTIMETER") == text.count("ALTIMETER") == 3
    (tmp_path / "onboard.toml").write_text(with_it)
    nav = load(tmp_path / "onboard.toml", OnboardConfig).nav
    assert nav.dbc is not None
    nav = msgspec.structs.replace(nav, dbc=msgspec.structs.replace(nav.dbc, window_s=0.05))
    with (
        on_can(tmp_path, nav, lambda bus: SimulatedDbcIns(bus, CONFIG / "sbg.dbc", FRAME)) as (client, ins),
        flying(SLOPE, ins) as flight,
    ):
        check(client, *flight)


def test_a_doppler_log_on_a_serial_line(tmp_path: Path) -> None:
    line = SerialLine(tmp_path / "ins")
    nmea = load(CONFIG / "onboard-nmea.toml", OnboardConfig).nav.nmea
    assert nmea is not None
    nmea = msgspec.structs.replace(nmea, port=str(tmp_path / "ins"))
    ins = SimulatedNmeaIns(lambda sentences: line.write(sentences, 0.005), FRAME)
    with nav_process(tmp_path, CanSettings(), nmea=nmea) as (_, client), flying(SLOPE, ins) as flight:
        check(client, *flight)
    line.unplug()


def test_the_two_eds_differ_by_the_height_only() -> None:
    plain, with_it = ((CONFIG / name).read_text().splitlines() for name in ("ins.eds", "ins_altitude.eds"))
    changes = [line for line in difflib.ndiff(plain, with_it) if line[0] in "+-"]
    gone = [line[2:].split("=")[0] for line in changes if line[0] == "-"]
    assert gone == ["FileName", "Description", "Line3", "SubNumber", "DefaultValue", "SupportedObjects"]
    assert sum(line[0] == "+" for line in changes) == len(gone) + 8 + 1 + 9  # a mapping entry, a name, an object
