"""A workbench that was started in a folder with a short scene and without data, and a hand that is new to it."""

import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from ods.base.files.shipped import shipped_file
from ods.cli import main
from tests.workbench.browser.conftest import Shared, running, untouched
from tests.workbench.browser.hand import Hand
from tests.workbench.serving import PROJECT

PAGE = PROJECT / "docs" / "workbench" / "tasks.md"
Counted = Callable[[str], None]


@pytest.fixture(scope="session")
def workbench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shared]:
    folder = tmp_path_factory.mktemp("engineer")
    scene = shipped_file("scenes/figure11.toml").read_text()
    (folder / "short.toml").write_text(re.sub(r"duration_s = [0-9.]+", "duration_s = 3.0", scene))
    with running(tmp_path_factory, folder=folder) as made:
        yield made


@pytest.fixture
def hand(workbench: Shared) -> Hand:
    Path(os.environ["ODS_DATA_DIR"], "ods", "recent.json").unlink(missing_ok=True)  # nothing was ever opened
    return Hand(untouched(workbench))


@pytest.fixture
def folder(workbench: Shared) -> Path:
    return workbench.folder


def counted(hand: Hand, task: str) -> None:
    """Compare what a hand did with what the docs say of a task: clicks and fields as there, and no more keys."""
    rows = re.findall(r"(?m)^\| (.+?) \| (\d+) \| (\d+) \| (\d+) \|", PAGE.read_text())
    said = {row[0]: tuple(map(int, row[1:])) for row in rows}
    clicks, keys, fields = said[task]
    assert (hand.clicks, hand.fields) == (clicks, fields)
    assert hand.keys <= keys


def run_on_the_bench(option: str, file: Path, seconds: int) -> int:
    """Return the exit code of `ods bench` with a file, beside any other bench that runs on this computer."""
    with tempfile.TemporaryDirectory(prefix="ods-task-") as own:  # short: sockets are in it
        shutil.copytree(PROJECT / "config", f"{own}/config")
        config = Path(own, "config", "bench.toml")
        config.write_text(config.read_text().replace('"/tmp/ods-bench"', f'"{own}/run"'))
        return main(
            ["bench", "--config", str(config), option, str(file), "--seconds", str(seconds), "--out", f"{own}/out"]
        )
