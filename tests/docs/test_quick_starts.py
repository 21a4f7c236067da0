"""Each quick start is followed against simulated devices: its configuration, its commands, what doctor prints."""

import json
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
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import pytest
import tomli_w

from ods.base.settings_file import load
from ods.bench.program import Program
from ods.bench.run_files import write_configs
from ods.bench.settings import BenchConfig
from ods.runtime.bus import BusSettings

pytestmark = pytest.mark.slow

PROJECT = Path(__file__).parents[2]
FOLDER = PROJECT / "docs" / "quick-starts"
PAGES = {page.stem: page.read_text() for page in FOLDER.glob("*.md")}
WITH_DEVICES = sorted(PAGES.keys() - {"bench-only"})
COMMAND = re.compile(r"^    \.venv/bin/ods (.+)$", re.MULTILINE)
FENCED = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
DEVICE = re.compile(r"tcp://[\d.:]+|/\S*/(?:by-id|run)/\S+(?=:)|/\S*/by-id/\S+")
NUMBER = re.compile(r"\d+(?:\.\d+)?(?=[ %])")
MOST_WORDS = 400


@pytest.fixture
def folder() -> Iterator[Path]:
    """A copy of config/, as `cp -r config mine` makes it."""
    with tempfile.TemporaryDirectory(prefix="ods-") as name:  # a socket path must be short
        shutil.copytree(PROJECT / "config", Path(name) / "config")
        shutil.copytree(PROJECT / "config", Path(name) / "mine")
        yield Path(name)


def blocks(page: str, kind: str) -> list[str]:
    return [text for found, text in FENCED.findall(PAGES[page]) if found == kind]


def command(page: str, name: str) -> list[str]:
    """Return the words of the page's first `ods NAME`."""
    return next(words for words in map(str.split, COMMAND.findall(PAGES[page])) if words[0] == name)


def run(folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    return subprocess.run(
        [sys.executable, "-m", "ods", *words], cwd=folder, env=environment, capture_output=True, text=True
    )


def free_port(kind: socket.SocketKind = socket.SOCK_STREAM) -> int:
    with socket.socket(socket.AF_INET, kind) as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def merged(into: dict[str, Any], lines: dict[str, Any]) -> dict[str, Any]:
    """Return a configuration with a page's lines in it."""
    both = {
        key: merged(into[key], value) if isinstance(value, dict) and key in into else value
        for key, value in lines.items()
    }
    return into | both


def configured(page: str, folder: Path) -> tuple[Path, Path]:
    """Write the page's configuration and the simulator's, with ports of their own; return both files."""
    bench = load(folder / command(page, "bench")[2], BenchConfig)
    mine = folder / command(page, "run")[2]
    (lines,) = blocks(page, "toml")
    mine.write_text(tomli_w.dumps(merged(tomllib.loads(mine.read_text()), tomllib.loads(lines))))
    sim = msgspec.structs.replace(bench.sim, sonar_tcp_port=free_port(), sonar_status_port=free_port(socket.SOCK_DGRAM))
    bus = BusSettings(run_dir=folder / "run")
    onboard, simulator = write_configs(
        msgspec.structs.replace(bench, onboard=mine, bus=bus, sim=sim, out=folder / "out", seconds=60.0)
    )
    text = onboard.read_text().replace("status_port = 52102", f"status_port = {sim.sonar_status_port}")
    onboard.write_text(text)
    return onboard, simulator


@contextmanager
def simulated(file: Path, folder: Path) -> Iterator[None]:
    """Devices at work."""
    with Program("sim", file, folder / "sim.log") as program:
        while "ready" not in (folder / "sim.log").read_text():
            program.check()
            time.sleep(0.1)
        yield
        program.check()


def shape(line: str) -> str:
    """Return a line of doctor's without names of devices and without measured numbers."""
    return NUMBER.sub("#", DEVICE.sub("DEVICE", line))


def list_becomes_valid(folder: Path, onboard: Path, words: list[str]) -> dict[str, Any]:
    """Look as often as needed; return the look that shows a valid list with an obstacle."""
    last: dict[str, Any] = {}
    for _ in range(40):
        last = json.loads(run(folder, *words[:2], str(onboard), "--once", "--json").stdout)
        if last["valid"] and last["list"]["obstacles"]:
            break
    return last


@pytest.mark.timeout(300)
@pytest.mark.parametrize("page", WITH_DEVICES)
def test_a_quick_start_leads_to_a_valid_list(page: str, folder: Path) -> None:
    onboard, simulator = configured(page, folder)
    doctor, started, watch = (command(page, name) for name in ("doctor", "run", "watch"))
    assert len({tuple(words[1:3]) for words in (doctor, started, watch)}) == 1  # one file in all of them
    with simulated(simulator, folder):
        time.sleep(2.0)  # a sonar boots
        said = run(folder, "doctor", "--config", str(onboard), *doctor[3:])
        assert said.returncode == 0, said.stdout
        (promised,) = blocks(page, "text")
        assert {shape(line) for line in promised.splitlines()} <= {shape(line) for line in said.stdout.splitlines()}
        with Program("run", onboard, folder / "run.log"):
            seen = list_becomes_valid(folder, onboard, watch)
    assert seen["valid"], seen["reasons"]
    assert seen["list"]["obstacles"]


@pytest.mark.timeout(300)
@pytest.mark.parametrize("page", sorted(PAGES))
def test_the_rehearsal_on_the_desk_works(page: str, folder: Path) -> None:
    words = command(page, "bench")
    file = folder / words[2]
    text = re.sub(r'run_dir = "\S+"', f'run_dir = "{folder}/run"', file.read_text())
    file.write_text(re.sub(r"sonar_tcp_port = \d+", f"sonar_tcp_port = {free_port()}", text))
    done = run(folder, *words[:-1], "8", "--out", str(folder / "out"))
    assert done.returncode in (0, 1), done.stderr  # 1: a limit of a whole mission
    found = json.loads((folder / "out" / "summary.json").read_text())
    assert found["tracked_share"] > 0.5
    assert found["invalid_lists"] < found["lists"] / 2


def test_images_of_a_scene_and_what_is_detected_in_them(folder: Path) -> None:
    for name in ("simulate", "detect"):
        done = run(folder, *command("bench-only", name))
        assert done.returncode == 0, done.stderr
    assert (folder / "sheet.png").stat().st_size > 10_000


def test_lines_for_a_recording_are_of_the_configuration(folder: Path) -> None:
    from ods.config import OnboardConfig

    (lines,) = blocks("bench-only", "toml")
    file = folder / "mine" / "onboard.toml"
    file.write_text(tomli_w.dumps(merged(tomllib.loads(file.read_text()), tomllib.loads(lines))))
    assert load(file, OnboardConfig).record.on


@pytest.mark.parametrize("page", sorted(PAGES))
def test_a_quick_start_is_short(page: str) -> None:
    assert len(PAGES[page].split()) < MOST_WORDS
