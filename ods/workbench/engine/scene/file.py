"""Scenes saved as files, after their difference has been shown; the sonars that come with ODS."""

import difflib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from ods.base.errors import OdsError, reason_of
from ods.base.files.in_file import text_of
from ods.base.files.shipped import FOLDER as SHIPPED
from ods.base.settings_file import load
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.files.folders import writable, write_whole
from ods.workbench.model.difference import changed_text, differences
from ods.workbench.model.scene.text import scene_text

MOST_NAMES = 1000


def shipped_sonars() -> list[str]:
    """Return the names of the sonars that come with ODS."""
    return sorted(file.stem for file in (SHIPPED / "sonars").glob("*.toml"))


class SavedScene(NamedTuple):
    """What saving would write."""

    path: Path
    text: str
    difference: str
    """To the file that is there, as `diff -u` shows it; empty where there is none."""


def saving(scene: SceneFile, path: str, folders: Iterable[Path]) -> SavedScene:
    """Return what saving a scene would do. Comments of the file that is there stay. Raises OdsError."""
    if not path.endswith(".toml"):
        raise OdsError(f"{path or 'file'}: a scene's name ends in .toml")
    file = writable(path, folders)
    try:
        old = text_of(file) if file.exists() else ""
        text = changed_text(old, differences(load(file, SceneFile), scene)) if old else scene_text(scene)
    except (OSError, ValueError) as error:
        raise OdsError(f"{file}: {reason_of(error) if isinstance(error, OSError) else error}") from error
    lines = difflib.unified_diff(old.splitlines(), text.splitlines(), str(file), "to be saved", lineterm="")
    return SavedScene(file, text, "\n".join(lines))


def proposed(opened: str, folders: Sequence[Path]) -> Path:
    """Return where to save: in the file that was opened, if it lies under the folders and did not come with ODS; else a
    name that is free in the first folder. opened: empty where the scene is new."""
    file = Path(opened or "scene.toml")
    folder = folders[0] if folders else Path()
    own = any(file.resolve().is_relative_to(each.resolve()) for each in folders)
    if opened and own and not file.resolve().is_relative_to(SHIPPED.resolve()):
        return file
    names = (file.name, *(f"{file.stem}-{number}{file.suffix}" for number in range(2, MOST_NAMES)))
    return next((place for name in names if not (place := folder / name).exists()), folder / file.name)


def save(saved: SavedScene) -> None:
    """Write a scene whole or not at all. Raises OdsError."""
    write_whole(saved.path, saved.text.encode())
