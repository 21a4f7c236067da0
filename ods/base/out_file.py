"""Files that a command shall write: refused before the work, not after it."""

import os
from pathlib import Path

from ods.base.errors import OdsError, reason_of


def refuse_unwritable(*paths: Path | None) -> None:
    """Raise OdsError, one line, for the first that cannot be written; None is a file that is not wanted."""
    for path in paths:
        why_not = "" if path is None else _why_not(path)
        if why_not:
            raise OdsError(f"{path}: {why_not}")


def _why_not(path: Path) -> str:
    try:
        if not path.parent.is_dir():
            return f"no such folder: {path.parent}"
        if path.is_dir():
            return "is a folder"
        there = path if path.exists() else path.parent
    except OSError as error:  # such as a name that is too long
        return reason_of(error)
    return "" if os.access(there, os.W_OK) else f"no right to write {there}, or its disk is read-only"
