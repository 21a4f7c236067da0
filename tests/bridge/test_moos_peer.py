"""The bridge to MOOS with a real MOOSDB, pShare and pObstacleMgr: alerts come, and end when the bridge falls silent.

tests/peers/build_moos.sh builds the programs; ODS_MOOS names their folder, without it there is nothing to test with.
"""

import os
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from ods.base import clock
from tests.bridge import moos_datagrams
from tests.bridge.played import Bridge, bridge, drained, receiver
from tests.bridge.samples import ROCK, SWIMMER

MOOS = Path(os.environ.get("ODS_MOOS", "nowhere"))

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (MOOS / "pObstacleMgr").exists(), reason="ODS_MOOS names no folder with pObstacleMgr"),
]

MISSION = """
ServerHost = 127.0.0.1
ServerPort = {db}
Community = test
LatOrigin = 57.048
LongOrigin = 9.9187
ProcessConfig = pShare
{{
  AppTick = 20
  CommsTick = 20
  Input = route=localhost:{into}
  Output = src_name=OBSTACLE_ALERT, route=127.0.0.1:{out}
  Output = src_name=OBM_RESOLVED, route=127.0.0.1:{out}
}}
ProcessConfig = pObstacleMgr
{{
  AppTick = 10
  CommsTick = 10
}}
"""


SAID: dict[str, float | str] = {
    "NAV_X": 20.0,
    "NAV_Y": 100.0,
    "OBM_ALERT_REQUEST": "name=avd,update_var=OBSTACLE_ALERT,alert_range=1000",
}
"""As navigation and BHV_AvoidObstacleV24 do."""


@contextmanager
def moos(into: int, out: int) -> Iterator[None]:
    """Run the three programs: datagrams come at the port `into`, alerts go to the port `out`."""
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        mission = Path(folder) / "test.moos"
        mission.write_text(MISSION.format(db=_free(socket.SOCK_STREAM), into=into, out=out))
        started = []
        for program in ("MOOSDB", "pShare", "pObstacleMgr"):
            with (Path(folder) / f"{program}.log").open("wb") as log:
                command = [program, str(mission)]  # its first word is the name by which it finds its block
                started.append(subprocess.Popen(command, executable=MOOS / program, stdout=log, stderr=log, cwd=folder))
        try:
            yield
        finally:
            for process in reversed(started):
                process.kill()
                process.wait()


def _free(kind: int) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Manager:
    """What pObstacleMgr says."""

    def __init__(self, peer: socket.socket, into: int) -> None:
        self._peer, self._into = peer, into
        self.alerts: dict[str, str] = {}
        self.resolved: set[str] = set()

    def heard(self) -> None:
        """Say what helm and navigation say, and take what has come."""
        for key, value in SAID.items():
            self._peer.sendto(moos_datagrams.written(key, value, clock.utc_ns() / 1e9), ("127.0.0.1", self._into))
        for message in map(moos_datagrams.read, drained(self._peer)):
            label = message.text.rpartition("id=")[2]
            if message.key == "OBSTACLE_ALERT":
                self.alerts[label] = message.text
            else:
                self.resolved.add(label)

    def alerted(self, running: Bridge, *labels: str) -> None:
        """Wait for new alerts."""
        self.alerts.clear()

        def all_there() -> bool:
            self.heard()
            return self.alerts.keys() >= set(labels)

        running.until(all_there)

    def forgot(self, running: Bridge, label: str) -> None:
        """Wait until an obstacle is forgotten."""

        def gone() -> bool:
            self.heard()
            return label in self.resolved

        running.until(gone)


def test_alerts_come_and_end_with_silence() -> None:
    into = _free(socket.SOCK_DGRAM)
    with receiver() as peer, moos(into, peer.getsockname()[1]), bridge("moos", into) as running:
        manager = Manager(peer, into)
        running.obstacles = [ROCK, SWIMMER]
        manager.alerted(running, "ods_7", "ods_300")
        assert "vsource=ods" in manager.alerts["ods_7"]
        corner = f"{50.0 + 2.8 / 0.92388:.2f}"  # to the east of the rock: x; as it was computed for test_moos.py
        assert f"{corner},100" in manager.alerts["ods_7"].replace("100.00", "100")

        running.obstacles = [ROCK]
        manager.forgot(running, "ods_300")
        assert "ods_7" not in manager.resolved  # it is sent, and goes on

        running.valid = False
        running.until(lambda: running.says("the list is not valid"))
        manager.forgot(running, "ods_7")

        manager.resolved.clear()
        running.valid = True
        manager.alerted(running, "ods_7")
