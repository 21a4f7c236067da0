"""Scenes as files: those that come with ODS, opened, and saved after their difference has been shown."""

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from ods.base.errors import OdsError, reason_of
from ods.base.settings_file import load
from ods.base.shipped import FOLDER as SHIPPED
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.folders import readable, writable
from ods.workbench.model.actions import OpenData
from ods.workbench.model.difference import changed_text, differences
from ods.workbench.model.scene_text import scene_text
from ods.workbench.model.short_tables import short_tables
from ods.workbench.model.state import DataReference


def shipped_scenes() -> dict[str, Path]:
    """Return the scenes that come with ODS, by name."""
    root = SHIPPED / "scenes"
    return {file.relative_to(root).with_suffix("").as_posix(): file for file in sorted(root.rglob("*.toml"))}


def shipped_sonars() -> list[str]:
    """Return the names of the sonars that come with ODS."""
    return sorted(file.stem for file in (SHIPPED / "sonars").glob("*.toml"))


def opening(path: Path, sonar: str, folders: Iterable[Path]) -> OpenData:
    """Return the action that opens a scene's file. Raises OdsError."""
    file = load(readable(path, folders), SceneFile)
    return OpenData(DataReference(kind="scene", path=str(path), sonar=sonar), short_tables(file))


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
        old = file.read_text(encoding="utf-8") if file.exists() else ""
        text = changed_text(old, differences(load(file, SceneFile), scene)) if old else scene_text(scene)
    except (OSError, ValueError) as error:
        raise OdsError(f"{file}: {reason_of(error) if isinstance(error, OSError) else error}") from error
    lines = difflib.unified_diff(old.splitlines(), text.splitlines(), str(file), "to be saved", lineterm="")
    return SavedScene(file, text, "\n".join(lines))


def save(saved: SavedScene) -> None:
    """Write a scene whole or not at all. Raises OdsError."""
    new = saved.path.with_name(f".{saved.path.name}.new")
    try:
        new.write_text(saved.text, encoding="utf-8")
        new.replace(saved.path)
    except OSError as error:
        new.unlink(missing_ok=True)
        raise OdsError(f"{saved.path}: {reason_of(error)}") from error
