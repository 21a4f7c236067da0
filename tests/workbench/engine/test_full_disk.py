"""A disk that takes no more: one line, what was there stays, and nothing half written is left."""

import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.base.files.shipped import shipped_file
from ods.sim_sonar.by_name import find_scene
from ods.workbench.engine.data import Data
from ods.workbench.engine.files.config_file import write_config
from ods.workbench.engine.files.presets import save_preset
from ods.workbench.engine.printing import print_ping, record_movie
from ods.workbench.engine.scene.file import save, saving
from ods.workbench.model.state import DataReference, State
from tests.workbench.engine.test_files import keep_dropped
from tests.workbench.engine.test_printing import SOURCE

SCENE = find_scene("figure11").file


@contextmanager
def full_disk() -> Iterator[None]:
    """Let no file of this process grow."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def movie(file: Path) -> None:
    data = Data(DataReference(), SOURCE.pings, SOURCE.poses)
    record_movie(data, State().tuning, file, [file.parent], tell=lambda _: False, style="dark")


WRITERS: dict[str, Callable[[Path], object]] = {
    "own.toml": lambda file: write_config(shipped_file("onboard.toml").read_text(), file, [file.parent]),
    "scene.toml": lambda file: save(saving(SCENE, str(file), [file.parent])),
    "workbench-presets/mine.preset": lambda file: save_preset("mine", State(), [file.parents[1]]),
    "ping.png": lambda file: print_ping(SOURCE.pings[0], State().tuning, file, [file.parent], name="", style="dark"),
    "mission.webp": movie,
    "dropped.mcap": lambda file: keep_dropped(file.name, b"x" * 999, [file.parent]),
}


def place(folder: Path, name: str) -> Path:
    """Return where a file is to be, once it has been written elsewhere: kernels are compiled and kept then."""
    for each in (folder / "other" / name, folder / "full" / name):
        each.parent.mkdir(parents=True)
    WRITERS[name](folder / "other" / name)
    return folder / "full" / name


@pytest.mark.parametrize("name", WRITERS)
def test_nothing_is_left_and_it_is_one_line(tmp_path: Path, name: str) -> None:
    file = place(tmp_path, name)
    with full_disk(), pytest.raises(OdsError, match=f"{file.name}: file too large$"):
        WRITERS[name](file)
    assert list(file.parent.iterdir()) == []


@pytest.mark.parametrize("name", ["own.toml", "workbench-presets/mine.preset", "ping.png"])
def test_what_was_there_stays(tmp_path: Path, name: str) -> None:
    file = place(tmp_path, name)
    file.write_text("before")
    with full_disk(), pytest.raises(OdsError):
        WRITERS[name](file)
    assert file.read_text() == "before"
    assert [each.name for each in file.parent.iterdir()] == [file.name]
