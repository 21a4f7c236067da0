"""Could somebody else have written a file, or put another in its place? What is run or trusted must be ours."""

import os
import stat
from pathlib import Path


def is_safe(path: Path) -> bool:
    """Return whether nobody but root and this user can write `path`, nor put another in its place."""
    return not weakness(path)


def weakness(path: Path) -> str:
    """Say why somebody else could write `path`, or put another in its place; "" when nobody could."""
    try:
        return next(filter(None, map(_not_ours, (path.resolve(), *path.resolve().parents))), "")
    except OSError as error:
        return f"{path}: {error.strerror}"


def _not_ours(place: Path) -> str:
    state = place.stat()
    if state.st_uid not in (0, os.geteuid()):
        return f"{place} belongs to another user"
    others_write = state.st_mode & (stat.S_IWGRP | stat.S_IWOTH) and not state.st_mode & stat.S_ISVTX
    return f"{place} can be written by others (chmod go-w)" if others_write else ""
