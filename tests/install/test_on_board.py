"""The wheel on board: installed without extras, it runs; what needs the extra says so in one line."""

import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from ods.cli import BENCH_EXTRA, EXPORT_EXTRA, ROS2_EXTRA
from ods.runtime.processes import on_board
from tests.install.clean_venv import ROOT, bare, build_wheel, install

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]

RECORDING = str(ROOT / "tests" / "data" / "oculus" / "three_pings_8bit.raw")
ONBOARD = ROOT / "ods" / "config_files" / "onboard.toml"


@pytest.fixture(scope="module")
def venv() -> Iterator[Path]:
    """Return the commands of an environment that all users can read."""
    with tempfile.TemporaryDirectory(prefix="ods-wheel-") as name:
        folder = Path(name)
        folder.chmod(0o755)
        wheel = build_wheel(ROOT, folder)
        assert re.search(r"-cp311-abi3-linux_\w+\.whl$", wheel.name)  # one for all versions of Python from 3.11 on
        yield install(wheel, "ods", folder / "venv")


def said(venv: Path, *arguments: str, **environment: str) -> tuple[int, str]:
    """Return the exit code of `ods` and all that it printed."""
    command = [str(venv / "ods"), *arguments]
    done = subprocess.run(
        command, env=bare(**environment), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    return done.returncode, done.stdout


@pytest.mark.parametrize(("name", "modules"), [("bench", BENCH_EXTRA), ("export", EXPORT_EXTRA), ("ros2", ROS2_EXTRA)])
def test_the_extra_is_what_the_commands_name(name: str, modules: frozenset[str]) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extra = {line.partition(">")[0] for line in project["optional-dependencies"][name]}
    brought = {distribution for module in modules for distribution in packages_distributions()[module]}
    assert {name.replace("_", "-") for name in brought} == extra


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """Return a configuration whose run folder and map lie below the test's folder, and whose CAN bus is no device."""
    text = ONBOARD.read_text().replace("[bus]", f'[bus]\nrun_dir = "{tmp_path}/run"').replace("~/", f"{tmp_path}/")
    for file in ONBOARD.parent.glob("*.eds"):
        shutil.copy(file, tmp_path)
    (tmp_path / "onboard.toml").write_text(text.replace('"socketcan"', '"virtual"'))
    return tmp_path / "onboard.toml"


def until_it_says_that_it_works(command: list[str], config: Path, environment: dict[str, str]) -> str:
    """Start a process, wait until its loop tells the watchdog so, end it; return what it said."""
    notify = config.parent / "notify"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as supervisor:
        supervisor.bind(str(notify))
        notify.chmod(0o666)
        supervisor.settimeout(30.0)
        begun = time.monotonic()
        started = subprocess.Popen(
            [*command, "--config", str(config)],
            env=environment | {"NOTIFY_SOCKET": str(notify)},
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            while "WATCHDOG=1" not in supervisor.recv(4096).decode():
                assert started.poll() is None
                assert time.monotonic() - begun < 30.0
        finally:
            started.terminate()
            errors = started.communicate()[1]
    return errors


@pytest.mark.parametrize("process", [process.name for process in on_board()])
def test_each_process_starts(venv: Path, config: Path, process: str) -> None:
    """Its loop runs and tells the watchdog so, though neither sonar nor CAN bus is there."""
    errors = until_it_says_that_it_works([str(venv / "ods"), process], config, bare())
    assert "Traceback" not in errors


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody else")
@pytest.mark.parametrize("process", ["pipeline", "tracker"])
def test_a_user_without_a_home_can_start_it(venv: Path, config: Path, process: str) -> None:
    nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    version = [*nobody, str(venv / "python"), "-c", "import sys; print(sys.version)"]
    if subprocess.run(version, capture_output=True, text=True, check=False).stdout.strip() != sys.version:
        pytest.skip("other users cannot run this interpreter")
    with tempfile.TemporaryDirectory(prefix="ods-nobody-") as name:  # pytest's own folders are for its user only
        theirs = Path(name)
        for file in config.parent.iterdir():
            text = file.read_text().replace(str(config.parent), name)
            (theirs / file.name).write_text(text)
        os.chown(theirs, 65534, 65534)
        environment = {"HOME": "/nonexistent", "PATH": os.defpath}
        command = [*nobody, str(venv / "ods"), process]
        errors = until_it_says_that_it_works(command, theirs / "onboard.toml", environment)
    assert "Traceback" not in errors


def test_help(venv: Path) -> None:
    code, text = said(venv, "--help")
    assert code == 0
    assert "set-sonar" in text


def test_doctor(venv: Path) -> None:
    code, text = said(venv, "doctor", "--config", str(ONBOARD))
    assert code == 1
    assert "configuration" in text
    assert "Traceback" not in text


def test_detect_without_extras(venv: Path) -> None:
    code, text = said(venv, "detect", "--json", RECORDING)
    assert code == 0
    assert len(text.splitlines()) == 3


def test_record_without_a_chain(venv: Path, tmp_path: Path) -> None:
    file = str(tmp_path / "a.s7k")
    code, text = said(venv, "record", "--s7k", file, "--seconds", "0.5", "--config", str(ONBOARD))
    assert code == 2
    assert text.startswith("ods record: nothing to record was received")
    assert len(text.splitlines()) == 1


@pytest.mark.parametrize(
    "command",
    [
        ("watch",),
        ("bench",),
        ("simulate", "--chart", "chart.png"),
        ("assess", "detect"),
        ("assess", "track"),
        ("detect", "--plot", "a.png", RECORDING),
    ],
    ids=lambda command: " ".join(command[:2]),
)
def test_what_needs_the_extra_says_so_in_one_line(venv: Path, command: tuple[str, ...]) -> None:
    code, text = said(venv, *command)
    assert code == 2
    assert "needs pip install 'ods[bench]'" in text
    assert len(text.splitlines()) == 1
