"""States kept under a name, as files of the user's own in the first of the workbench's folders."""

import re
from collections.abc import Sequence
from pathlib import Path

from ods.base.errors import OdsError, reason_of
from ods.base.files.in_file import content_of
from ods.workbench.engine.files.folders import write_whole
from ods.workbench.model.share import shared_text, state_of
from ods.workbench.model.state import State

FOLDER, SUFFIX = "workbench-presets", ".preset"
LONGEST = 60
NAME = re.compile(rf"\w[\w .,+-]{{0,{LONGEST - 1}}}")


def preset_names(folders: Sequence[Path]) -> list[str]:
    """Return the names of what is kept, in order."""
    return sorted(file.stem for folder in folders[:1] for file in (folder / FOLDER).glob(f"*{SUFFIX}"))


def save_preset(name: str, state: State, folders: Sequence[Path]) -> Path:
    """Keep a state, instead of one of the same name; return its file. Raises OdsError."""
    file = _file(name, folders)
    try:
        file.parent.mkdir(exist_ok=True)
    except OSError as error:
        raise OdsError(f"{file}: {reason_of(error)}") from error
    write(file, state)
    return file


def file_name(name: str) -> str:
    """Return what the file of a preset is called."""
    return f"{name}{SUFFIX}"


def write(file: Path, state: State) -> None:
    """Write a state as a file. Raises OdsError."""
    write_whole(file, f"{shared_text(state)}\n".encode())


def load_preset(name: str, trusted: State, folders: Sequence[Path]) -> State:
    """Return a state that was kept; files of code are those of `trusted`. Raises OdsError."""
    return state_in(_file(name, folders), trusted)


def state_in(file: Path, trusted: State) -> State:
    """Return the state of such a file; files of code are those of `trusted`. Raises OdsError."""
    try:
        text = content_of(file).decode("ascii", "replace")
    except OSError as error:
        raise OdsError(f"{file}: {reason_of(error)}") from error
    return state_of(text.strip(), trusted)


def _file(name: str, folders: Sequence[Path]) -> Path:
    if not NAME.fullmatch(name):
        shown = name if len(name) <= LONGEST else f"{name[:LONGEST]}..."
        raise OdsError(f"preset {shown!r}: a name has 1 to {LONGEST} letters, digits, blanks, and . , + - _")
    if not folders:
        raise OdsError("presets: the workbench has no folder for them; add one with --folder")
    return folders[0] / FOLDER / file_name(name)
