"""Somebody else's sonar, INS and planners (docs/examples/integrator, without code of ODS) on a real `ods run`.

What comes out at the planners is the object, where it is.
"""

import json
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from ods.client import Obstacles
from tests.client.compiled import compiled

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "docs" / "examples" / "integrator"
OBJECT_NED = 152.0, 84.0, 10.0
"""62 m from the vehicle's start, 4 deg to starboard of its heading."""
TOLERANCE_M = 1.5
"""A beam is 1.9 deg wide, 2 m there."""
PATIENCE_S = 240.0
LISTS = 16
PATIENT = "[supervise]\nwatchdog_s = 20.0\n"
"""A guest kernel's CPUs may be emulated: processes then start in half a minute."""
REFUSAL = "the sonar refused range 500 m (error 2): it reports 80 m"


class Integration:
    """Devices, `ods run` and the way to start planners."""

    def __init__(self, folder: Path, kind: str, channel: str) -> None:
        self.run_dir = folder / "run"
        port = _free_port()
        sonar, line = (f"tcp:{port}", "7000") if kind == "canopen" else (f"serial:{folder}/seabat", "/tmp/seabat")
        text = (EXAMPLES / f"{kind}.toml").read_text().replace('"../../../config', f'"{ROOT}/config')
        text = text.replace(line, str(port) if kind == "canopen" else f"{folder}/seabat").replace("vcan0", channel)
        shutil.copy(EXAMPLES / "awkward.dbc", folder)
        config = folder / "onboard.toml"
        config.write_text(f'{text}\n[bus]\nrun_dir = "{self.run_dir}"\n{PATIENT}')
        start = str(time.monotonic())
        self._processes = [
            self._start(str(EXAMPLES / "seabat.py"), sonar, start, *map(str, OBJECT_NED)),
            self._start(str(EXAMPLES / f"{kind}_ins.py"), channel, start),
            self._start("-m", "ods", "run", "--config", str(config)),
        ]

    def _start(self, *arguments: str) -> psutil.Popen:
        return psutil.Popen([sys.executable, *arguments])

    def until_it_is_seen(self) -> None:
        """Wait for a list that is valid and has an object that is certain."""
        lists = Obstacles(self.run_dir)
        deadline_s = time.monotonic() + PATIENCE_S
        while not ((newest := lists.next()).valid and any(o.times_seen > 20 for o in newest.obstacles)):
            assert time.monotonic() < deadline_s, newest
            assert all(process.poll() is None for process in self._processes)
        lists.close()

    def close(self) -> None:
        for process in reversed(self._processes):
            if process.poll() is None:
                process.terminate()
            process.wait(20.0)


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


@pytest.fixture(params=["canopen", "dbc"])
def integration(vcan0: str, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Integration]:
    made = Integration(tmp_path, request.param, vcan0)
    yield made
    made.close()


def planners(folder: Path) -> dict[str, list[str]]:
    """Return the commands of the planners that this machine can run."""
    found = {"python": [sys.executable, str(EXAMPLES / "planner.py")]}
    if node := shutil.which("node"):
        found["javascript"] = [node, str(EXAMPLES / "planner.js")]
    if shutil.which("cc"):
        found["c"] = [str(compiled("cc", EXAMPLES / "planner.c", folder))]
    print("planners in", ", ".join(found))
    return found


@pytest.mark.timeout(600)
def test_what_the_planners_get_is_the_object_where_it_is(integration: Integration, tmp_path: Path) -> None:
    commands = planners(tmp_path)
    integration.until_it_is_seen()
    started = {}
    for name, command in commands.items():
        asks = ["500"] if name == "python" else []
        command = [*command, str(integration.run_dir), str(LISTS), *asks]
        started[name] = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    said = {name: [json.loads(line) for line in process.communicate(timeout=120.0)[0].splitlines()]
            for name, process in started.items()}  # fmt: skip
    answer = said["python"].pop(0)["answer"]
    assert (answer["ok"], answer["reason"]) == (False, REFUSAL)
    for name, pictures in said.items():
        assert len(pictures) == LISTS, name
        assert not [picture for picture in pictures if any("refused" in why for why in picture.get("reasons", []))]
        relied_on = [picture["positions"] for picture in pictures if picture["valid"]]
        assert len(relied_on) >= LISTS // 4, pictures  # under emulation poses come late now and then
        for (position,) in relied_on:
            off = [there - here for there, here in zip(position[:2], OBJECT_NED[:2], strict=True)]
            assert abs(off[0]) + abs(off[1]) < TOLERANCE_M, (name, position)
