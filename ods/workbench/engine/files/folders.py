"""Files that a workbench may read and write: those under the folders it was given at the start."""

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from ods.base.errors import OdsError, reason_of
from ods.base.files.shipped import FOLDER as SHIPPED
from ods.workbench.engine.files.user_folders import data_folder


class FolderError(OdsError):
    """A file lies elsewhere; the text is one line."""


def readable(path: str | Path, folders: Iterable[Path]) -> Path:
    """Return where a file is, links followed: under one of `folders`, of the user's uploads, or of those that come with
    ODS. Raises FolderError."""
    own = uploads_folder()
    place = _under(Path(path), [*folders, SHIPPED, *([own] if own else [])])
    if place.exists() and not (place.is_file() or place.is_dir()):
        raise FolderError(f"{path}: neither a file nor a folder")  # to open a pipe would wait for ever
    return place


def uploads_folder() -> Path | None:
    """Return where files are kept that came from a browser; None: the user has no folder for data."""
    own = data_folder()
    return None if own is None else own / "uploads"


def writable(path: str | Path, folders: Iterable[Path]) -> Path:
    """Return where a file is to be written: under one of `folders`. Raises FolderError."""
    return _under(Path(path), list(folders))


@contextmanager
def new_beside(file: Path) -> Iterator[tuple[Path, BinaryIO]]:
    """Open a new file in the folder of `file`, to be written, closed and put in its place; else it is gone afterwards.

    What the system refuses meanwhile is an OdsError that names `file`.
    """
    try:
        descriptor, name = tempfile.mkstemp(file.suffix, ".new-", file.parent)
        new = Path(name)
        try:
            with os.fdopen(descriptor, "wb") as writing:
                yield new, writing
        finally:
            new.unlink(missing_ok=True)
    except OSError as error:
        raise OdsError(f"{file}: {reason_of(error)}") from error


def write_whole(file: Path, content: bytes, check: Callable[[Path], object] = Path.exists) -> None:
    """Write a file whole or not at all, with the rights of the one that is there.

    check: looks at what has been written before it takes the place, and may raise. Raises OdsError.
    """
    with new_beside(file) as (new, writing):
        writing.write(content)
        writing.close()
        check(new)
        new.chmod(file.stat().st_mode if file.exists() else 0o644)
        new.replace(file)


def _under(path: Path, folders: list[Path]) -> Path:
    try:
        place = path.expanduser().resolve()
        inside = any(place.is_relative_to(folder.resolve()) for folder in folders)
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links, no home, a zero byte
        raise FolderError(f"{path}: {' '.join(str(error).split())}") from error
    if not inside:
        shown = ", ".join(map(str, folders)) or "none"
        raise FolderError(f"{path}: not under the workbench's folders ({shown}); add one with --folder")
    return place
