"""The live menu, without a browser, on a real bus."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import groupby
from pathlib import Path

import msgspec
import numpy as np
import pytest
from nicegui import ui
from nicegui.testing import User

from ods.base.arrays import SAMPLE_DTYPES
from ods.messages import Ping, SampleType
from ods.plots.polar import level_db
from ods.workbench.model.state import DataReference, State, View
from ods.workbench.pages import live
from ods.workbench.pages.parts.live_image import frame_of_ping
from ods.workbench.session import Session
from tests.export import mission
from tests.workbench.engine.test_live import HEALTH, Vehicle
from tests.workbench.pages.test_observer import until
from tests.workbench.pages.visiting import simulated


@pytest.fixture
def vehicle(tmp_path: Path) -> Iterator[Vehicle]:
    with ExitStack() as stack:
        yield Vehicle(tmp_path, stack)


async def test_verdict_processes_and_silence_are_said(tmp_path: Path, vehicle: Vehicle) -> None:
    session = Session(State(data=DataReference(kind="live", path=str(tmp_path))))
    async with simulated(lambda: live.build(session)) as user:
        await user.open("/")
        await user.should_see("NOT VALID: no obstacle list yet")
        time.sleep(0.3)  # until the sockets have found each other
        vehicle.tell(valid=True, reasons=[])
        vehicle.report(msgspec.structs.replace(HEALTH, counters={"echoes_bad": 2}))
        await user.should_see("VALID: a planner may rely on the list", retries=30)
        vehicle.tell(valid=False, reasons=["nav: CAN bus off"])
        await user.should_see("NOT VALID: nav: CAN bus off", retries=30)
        (silence,) = user.find(marker="live-silence").elements
        assert isinstance(silence, ui.label)
        assert "no pings yet" in silence.text
        tables = [each for each in user.find(kind=ui.table).elements if isinstance(each, ui.table)]
        processes = next(each for each in tables if each.row_key == "process")
        tracker = next(row for row in processes.rows if row["process"] == "tracker")
        assert tracker["state"] == "✓ ready"
        assert tracker["counters"] == "echoes_bad 2"
        sonar = next(row for row in processes.rows if row["process"] == "sonar")
        assert sonar["state"] == "✗ not heard of"
        await until(lambda: "NOT VALID: no obstacle list for" in banner(user))
    listening = live.live_of(session)
    assert listening is not None
    listening.close()


def banner(user: User) -> str:
    (label,) = user.find(marker="live-verdict").elements
    assert isinstance(label, ui.label)
    return str(label.text)


async def test_a_bus_that_vanishes_is_said_and_received_again_when_it_is_back(tmp_path: Path) -> None:
    """The process is killed, so that its sockets stay, and another takes its place."""
    session = Session(State(data=DataReference(kind="live", path=str(tmp_path))))
    async with simulated(lambda: live.build(session)) as user:
        await user.open("/")
        for _ in range(2):
            with talking(tmp_path):
                await until(lambda: banner(user).startswith("VALID"))
            await until(lambda: "NOT VALID: no obstacle list for" in banner(user))
    listening = live.live_of(session)
    assert listening is not None
    listening.close()
    said = (line.text.partition(":")[0] for line in listening.log if line.text.startswith("the list is"))
    reported = [each for each, _ in groupby(said)]  # while it is not valid, the reason may change
    assert reported[-4:] == ["the list is valid", "the list is NOT VALID"] * 2


@contextmanager
def talking(run_dir: Path) -> Iterator[None]:
    """Let a process publish valid lists, until it is killed."""
    program = f"""
import time
from contextlib import ExitStack
from pathlib import Path
from tests.workbench.engine.test_live import Vehicle
with ExitStack() as stack:
    vehicle = Vehicle(Path({str(run_dir)!r}), stack)
    while True:
        vehicle.tell(valid=True, reasons=[])
        time.sleep(0.05)
"""
    process = subprocess.Popen([sys.executable, "-c", program])
    try:
        yield
    finally:
        process.kill()
        process.wait()


async def test_without_a_bus_it_says_how_to_get_one() -> None:
    session = Session(State())
    async with simulated(lambda: live.build(session)) as user:
        await user.open("/")
        await user.should_see("No vehicle's bus is shown")


@pytest.mark.parametrize("dtype", ["u1", "u2", "f4"])
def test_cells_are_decibels_over_the_median(dtype: SampleType) -> None:
    """Against the levels of `ods.plots`, computed sample by sample."""
    samples = np.random.default_rng(3).integers(1, 250, (7, 301)).astype(SAMPLE_DTYPES[dtype])
    bearing = np.linspace(-0.5, 0.5, 7).tolist()
    ping = Ping(0, 7, 0, 0, 0, 7, 301, dtype, samples.tobytes(), bearing, 1.0, 0.05, 1500.0)
    view = View(lowest_db=-20.0, highest_db=20.0)
    shown = frame_of_ping(ping, None, view)
    levels = level_db(ping)
    expected = (levels - np.median(levels) + 20.0) / 40.0 * 255.0
    assert np.abs(shown.cells - np.clip(expected, 0.0, 255.0)).max() <= 0.51
    assert shown.caption == "ping 7"


def test_detections_of_the_ping_are_circles() -> None:
    shown = frame_of_ping(mission.PING, mission.DETECTIONS, View())
    assert [circle.range_m for circle in shown.circles] == [each.range_m for each in mission.DETECTIONS.detections]
    assert f"{len(shown.circles)} detections" in shown.caption
