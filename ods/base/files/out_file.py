"""Files that a command shall write: refused before the work, not after it; and never left half written."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from ods.base.errors import OdsError, reason_of


def refuse_unwritable(*paths: Path | None, read: Sequence[Path | None] = ()) -> None:
    """Raise OdsError, one line, for the first that cannot be written, or would go over one that is `read` or written.

    None is a file that is not wanted.
    """
    wanted = [path for path in paths if path is not None]
    for place, path in enumerate(wanted):
        why_not = _why_not(path)
        if not why_not and _is_one_of(path, read):
            why_not = "is an input, and is not overwritten"
        if not why_not and _is_one_of(path, wanted[:place]):
            why_not = "two results cannot be written to one file"
        if why_not:
            raise OdsError(f"{path}: {why_not}")


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a name beside `path` to write to; it becomes `path` in the end, and is removed if that is not reached.

    A device is written to as it is.
    """
    suffix, path = path.suffix, path.resolve()
    if path.exists() and not path.is_file():
        yield path
        return
    part = path.with_name(f"{path.stem}.{os.getpid()}.part{suffix}")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def opened_to_seek(path: Path) -> Iterator[BinaryIO]:
    """Open a file for who goes back and forth in it; a device, such as /dev/null, gets it once it is whole."""
    with path.open("wb") as file:
        if path.is_file():
            yield file
            return
        whole = BytesIO()
        yield whole
        file.write(whole.getvalue())


def _why_not(path: Path) -> str:
    try:
        if not path.parent.is_dir():
            return f"no such folder: {path.parent}"
        if path.is_dir():
            return "is a folder"
        there = path if path.exists() else path.parent
    except OSError as error:  # such as a name that is too long
        return reason_of(error)
    return "" if os.access(there, os.W_OK) else f"no permission to write {there}, or its disk is read-only"


def _is_one_of(path: Path, others: Sequence[Path | None]) -> bool:
    """Return whether `path` is a file of `others` by any name; of devices, such as /dev/null, none is."""
    if path.exists() and not path.is_file():
        return False
    return any(other is not None and _is_same(path, other) for other in others)


def _is_same(one: Path, other: Path) -> bool:
    if one.exists() and other.exists():
        return one.samefile(other)
    return one.resolve() == other.resolve()
