"""Files that can be opened: those of known endings under the workbench's folders, and the scenes that come with ODS."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from ods.base.errors import OdsError
from ods.base.files.in_file import opened
from ods.base.files.shipped import FOLDER as SHIPPED
from ods.base.settings_file import load
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.files.folders import readable
from ods.workbench.model.actions import OpenData
from ods.workbench.model.paths import tables_of
from ods.workbench.model.state import DataReference

RECORDINGS = (".npz", ".s7k", ".aris", ".raw", ".oculus", ".wbms", ".sonar", ".avi", ".mcap")
SCENE = ".toml"
ENDINGS = (*RECORDINGS, SCENE)
MOST_LISTED, MOST_SEEN, DEEPEST = 500, 20_000, 5


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
    """Distinguish a scene from other files of settings by its beginning."""
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
