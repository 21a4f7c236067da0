"""Files that can be opened: those of known endings under the workbench's folders, and the scenes that come with ODS."""

import filecmp
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from ods.base.errors import OdsError
from ods.base.files.in_file import opened
from ods.base.files.shipped import FOLDER as SHIPPED
from ods.base.settings_file import load
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.files.folders import readable, writable
from ods.workbench.model.actions import OpenData
from ods.workbench.model.paths import tables_of
from ods.workbench.model.state import DataReference

RECORDINGS = (".npz", ".s7k", ".aris", ".raw", ".oculus", ".wbms", ".sonar", ".avi", ".mcap")
SCENE = ".toml"
ENDINGS = (*RECORDINGS, SCENE)
MOST_LISTED, MOST_SEEN, DEEPEST = 500, 20_000, 5
MOST_BYTES = 1 << 30
"""Of a file that is dropped onto the page."""


class Openable(NamedTuple):
    """A file that may be opened."""

    name: str
    """As lists show it: under its folder."""
    path: Path


def openable(folders: Sequence[Path]) -> list[Openable]:
    """Return recordings and scenes under the folders, newest first; of very many files not all are looked at."""
    found: dict[Path, tuple[float, Openable]] = {}
    for folder in folders:
        for path, changed in _files(folder):
            found.setdefault(path, (changed, Openable(str(path.relative_to(folder)), path)))
    newest = sorted(found.values(), key=lambda each: -each[0])
    return [each for _, each in newest[:MOST_LISTED]]


def shipped_scenes() -> list[Openable]:
    """Return the scenes that come with ODS."""
    folder = SHIPPED / "scenes"
    return [Openable(str(path.relative_to(folder)), path) for path in sorted(folder.rglob(f"*{SCENE}"))]


def opening(path: str | Path, folders: Sequence[Path]) -> OpenData:
    """Return the action that opens a file: a scene by its tables, anything else by its name. Raises OdsError."""
    file = readable(path, folders)
    if file.suffix == SCENE:
        return OpenData(DataReference(kind="scene", path=str(file)), tables_of(load(file, SceneFile)))
    if not file.exists():
        raise OdsError(f"{file}: no such file")
    return OpenData(DataReference(kind="file", path=str(file)))


def place_of_dropped(name: str, folders: Sequence[Path]) -> Path:
    """Return where a file that is dropped onto the page would be kept: in the first folder. Raises OdsError."""
    plain = Path(name).name
    if Path(plain).suffix.lower() not in ENDINGS:
        raise OdsError(f"{plain}: the ending must be one of {', '.join(ENDINGS)}")
    if not folders:
        raise OdsError(f"{plain}: the workbench has no folder to keep it in; --folder gives one")
    return writable(folders[0] / plain, folders)


def keep_dropped(new: Path, wanted: Path) -> Path:
    """Move a file that was written whole to its place, or to one named like it that is free; return where it is.

    A file with the same content that is there already will do. Raises OSError.
    """
    new.chmod(0o644)
    place, number = wanted, 0
    while True:
        try:
            place.touch(exist_ok=False)
        except FileExistsError:
            if place.is_file() and filecmp.cmp(place, new, shallow=False):
                return place
        else:
            return new.replace(place)
        number += 1
        place = wanted.with_name(f"{wanted.stem}-{number}{wanted.suffix}")


def _files(folder: Path) -> Iterator[tuple[Path, float]]:
    seen = 0
    for place, folders, names in os.walk(folder):
        depth = len(Path(place).relative_to(folder).parts)
        folders[:] = [name for name in folders if not name.startswith(".") and depth < DEEPEST]
        for name in names:
            seen += 1
            path = Path(place, name)
            if path.suffix.lower() in RECORDINGS or (path.suffix == SCENE and _is_scene(path)):
                yield path, _changed(path)
        if seen > MOST_SEEN:
            return


def _is_scene(path: Path) -> bool:
    """Tell a scene from other files of settings by its beginning."""
    try:
        with opened(path) as file:
            return b"\nseed" in b"\n" + file.read(4096)
    except OSError:
        return False


def _changed(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
