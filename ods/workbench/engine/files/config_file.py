"""The configuration's file: loaded, and saved as the TOML that runs on board, after its difference has been shown."""

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import msgspec

from ods.base.errors import OdsError, reason_of
from ods.base.files.in_file import text_of
from ods.base.files.shipped import shipped_file
from ods.base.settings_file import load
from ods.config import OnboardConfig, part_of
from ods.offline.mission import MissionSettings
from ods.workbench.engine.files.folders import writable, write_whole
from ods.workbench.model.difference import Difference, changed_text, differences, with_texts
from ods.workbench.model.state import Tuning

TEMPLATE = "onboard.toml"
"""What a configuration of one's own begins with."""


class ConfigFile(NamedTuple):
    """A file as it was loaded."""

    path: Path
    text: str
    config: MissionSettings
    """What pipeline and tracker read of it."""


def load_config(path: Path | None = None) -> ConfigFile:
    """Load a configuration; none: the one that comes with ODS. Raises OdsError, one line."""
    file = shipped_file(TEMPLATE) if path is None else path
    config = load(file, OnboardConfig)
    try:
        text = text_of(file)
    except OSError as error:
        raise OdsError(f"{file}: {reason_of(error)}") from error
    return ConfigFile(file, text, part_of(config, MissionSettings))


def refuse_new_plugins(loaded: ConfigFile, trusted: ConfigFile) -> None:
    """Raise OdsError when a configuration names plug-ins that another does not: pages must not choose what is run."""
    for table in ("pipeline", "tracker"):
        known = {_module_of(place) for place in getattr(trusted.config, table).plugins}
        for index, place in enumerate(getattr(loaded.config, table).plugins):
            if _module_of(place) not in known:
                raise OdsError(
                    f"{loaded.path}: {table}.plugins[{index}] ({_module_of(place)}): a plug-in is code, which is "
                    "run only where the configuration that the workbench was started with names it: --config"
                )


def _module_of(place: Path) -> str:
    """Return what a plug-in is known by: its file, or the name of its module."""
    return str(place.resolve()) if place.suffix == ".py" else place.name


class Saving(NamedTuple):
    """What saving would do."""

    changes: list[Difference]
    text: str
    """Of the file."""

    def difference(self, loaded: ConfigFile) -> str:
        """Return the difference to the file loaded, as `diff -u` shows it; empty where there is none."""
        lines = difflib.unified_diff(
            loaded.text.splitlines(), self.text.splitlines(), str(loaded.path), "saved", lineterm=""
        )
        return "\n".join(lines)


def saving(loaded: ConfigFile, tuning: Tuning) -> Saving:
    """Return the file that a tuning is on board: the one loaded with what differs. Stages bypassed are left out.

    Raises OdsError.
    """
    changes = differences(loaded.config, _spelled_as_loaded(loaded.config, tuning.mission()))
    try:
        return Saving(changes, changed_text(loaded.text, changes))
    except ValueError as error:
        raise OdsError(f"{loaded.path}: {error}") from error


def _spelled_as_loaded(loaded: MissionSettings, settings: MissionSettings) -> MissionSettings:
    """Return settings with the default chain left to be the default, where it stands in full but unchanged."""
    pipeline = settings.pipeline
    if loaded.pipeline.stage or pipeline.stage != loaded.pipeline.chain():
        return settings
    return msgspec.structs.replace(settings, pipeline=msgspec.structs.replace(pipeline, stage=()))


def for_folder(text: str, loaded: ConfigFile, folder: Path) -> str:
    """Return a configuration's text for another folder: files that it names beside the one loaded are named in full."""
    here = loaded.path.resolve().parent
    if folder.resolve() == here:
        return text
    return with_texts(text, lambda name: str(here / name) if name and (here / name).is_file() else name)


def write_config(text: str, path: Path, folders: Iterable[Path]) -> Path:
    """Write a configuration whole or not at all, once it loads; return where it is. Raises OdsError."""
    file = writable(path, folders)
    write_whole(file, text.encode(), lambda new: load(new, OnboardConfig))
    return file
