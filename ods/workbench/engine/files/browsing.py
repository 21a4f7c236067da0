"""What an open dialog lists: one folder at a time, and the files that were opened last."""

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import msgspec

from ods.base.errors import OdsError, reason_of
from ods.base.files.in_file import content_of
from ods.workbench.engine.files.folders import readable, write_whole
from ods.workbench.engine.files.openable import ENDINGS
from ods.workbench.engine.files.user_folders import data_folder

MOST_LISTED = 2_000
"""Of a folder's entries: of one with more the rest is not looked at."""
MOST_RECENT = 15
SEGMENT = ".mcap"


class Entry(NamedTuple):
    """A folder, or a file of a known ending."""

    name: str
    path: Path
    is_folder: bool
    size: int = 0
    changed_s: float = 0.0
    """UTC."""


class Listing(NamedTuple):
    """Contents of a folder."""

    entries: list[Entry]
    """Folders first, each by name."""
    is_cut: bool
    """There is more in it than is listed."""
    is_recording: bool
    """Segments of `ods record` lie in it: it may be opened as a whole."""


def listing(folder: Path, folders: Sequence[Path]) -> Listing:
    """Return what can be opened in a folder, or gone into. Raises OdsError."""
    place = readable(folder, folders)
    found: list[Entry] = []
    seen = 0
    try:
        with os.scandir(place) as entries:
            for entry in entries:
                seen += 1
                if seen > MOST_LISTED:
                    break
                with contextlib.suppress(OSError, OdsError):
                    found += _shown(entry, folders)
    except OSError as error:
        raise OdsError(f"{place}: {reason_of(error)}") from error
    found.sort(key=lambda each: (not each.is_folder, each.name.casefold()))
    return Listing(found, seen > MOST_LISTED, any(each.path.suffix == SEGMENT for each in found))


def _shown(entry: "os.DirEntry[str]", folders: Sequence[Path]) -> list[Entry]:
    path = Path(entry.path)
    is_folder = entry.is_dir()
    if entry.name.startswith(".") or not (is_folder or path.suffix.lower() in ENDINGS):
        return []
    if entry.is_symlink():
        readable(path, folders)  # one that leads elsewhere is not listed
    if is_folder:
        return [Entry(entry.name, path, True)]
    about = entry.stat()
    return [Entry(entry.name, path, False, about.st_size, about.st_mtime)] if entry.is_file() else []


def recent(folders: Sequence[Path]) -> list[Entry]:
    """Return the files that were opened last, the newest first, as far as they are there and may be read."""
    found = []
    for text in _kept():
        with contextlib.suppress(OSError, OdsError):
            path = readable(text, folders)
            about = path.stat()
            found.append(Entry(str(path), path, path.is_dir(), about.st_size, about.st_mtime))
    return found


def note(path: str) -> None:
    """Keep a file as the one that was opened last. Where that cannot be written it is not kept."""
    file = _list_of_recent()
    if file is not None:
        newest = [path, *(each for each in _kept() if each != path)][:MOST_RECENT]
        with contextlib.suppress(OdsError):
            write_whole(file, msgspec.json.encode(newest))


def _kept() -> list[str]:
    file = _list_of_recent()
    try:
        return [] if file is None else msgspec.json.decode(content_of(file), type=list[str])[:MOST_RECENT]
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError):
        return []


def _list_of_recent() -> Path | None:
    own = data_folder()
    return None if own is None else own / "recent.json"
