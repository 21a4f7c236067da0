"""`ods run` with the real processes: what cannot start takes nothing else down, and comes back when repaired."""

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest

from ods.client import ObstacleList, Obstacles

CONFIG = Path(__file__).parents[2] / "config"
PATIENCE_S = 180.0


class Run:
    """A running `ods run` without devices, and a planner that listens."""

    def __init__(self, folder: Path) -> None:
        text = (CONFIG / "onboard.toml").read_text().replace("[bus]", f'[bus]\nrun_dir = "{folder}/run"')
        text = text.replace("~/", f"{folder}/").replace('"socketcan"', '"virtual"').replace("/dev/ttyUSB0", "/dev/none")
        for file in CONFIG.glob("*.eds"):
            shutil.copy(file, folder)
        self.config = folder / "onboard.toml"
        self.config.write_text(text + "\n[supervise]\nlongest_delay_s = 0.5\n")
        command = [sys.executable, "-m", "ods", "run", "--config", str(self.config)]
        self.process = psutil.Popen(command)
        self.planner = Obstacles(folder / "run")

    def pid(self, name: str) -> int:
        """Return the process that runs `ods NAME`; -1: none."""
        found = (child.pid for child in self.process.children() if name in child.cmdline())
        return next(found, -1)

    def wait(self, wanted: Callable[[ObstacleList], bool]) -> ObstacleList:
        """Return the first list that is wanted."""
        deadline_s = time.monotonic() + PATIENCE_S
        while not wanted(picture := self.planner.next()):
            assert time.monotonic() < deadline_s, picture
        return picture

    def close(self) -> None:
        """End all."""
        self.planner.close()
        self.process.terminate()
        try:
            assert self.process.wait(10.0) == 0
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


@pytest.fixture
def run() -> Iterator[Run]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        running = Run(Path(folder))
        yield running
        running.close()


def test_a_configuration_broken_while_running_takes_one_process_and_is_reported_until_it_is_mended(run: Run) -> None:
    def of_nav(picture: ObstacleList) -> str:
        return "; ".join(reason for reason in picture.reasons if reason.startswith("nav: ended"))

    run.wait(lambda picture: picture.seq > 0)
    others = {name: run.pid(name) for name in ("tracker", "sonar")}
    whole = run.config.read_text()
    run.config.write_text(whole.replace("[nav.can]", "[nav.can]\nbitrote = 7"))
    psutil.Process(run.pid("nav")).kill()
    reported = run.wait(lambda picture: of_nav(picture) != "")
    assert not reported.valid
    assert (
        of_nav(reported) == f"nav: ended with code 2: {run.config}: nav.can.bitrote: unknown key (did you mean bitrate)"
    )
    run.config.write_text(whole)
    run.wait(lambda picture: not of_nav(picture))
    assert run.pid("nav") > 0
    assert {name: run.pid(name) for name in others} == others


def test_a_tracker_that_cannot_start_is_said_by_the_client(run: Run) -> None:
    run.wait(lambda picture: picture.seq > 0)
    whole = run.config.read_text()
    run.config.write_text(whole.replace("[tracker.map]", '[tracker]\nobserver = "kalman"\n[tracker.map]'))
    psutil.Process(run.pid("tracker")).kill()
    reported = run.wait(lambda picture: "code 2" in picture.reasons[0])
    assert not reported.valid
    assert "observer" in reported.reasons[0]
    run.config.write_text(whole)
    run.wait(lambda picture: not picture.reasons[0].startswith("tracker: no obstacle list"))
