"""Tests whether another user could have written or replaced a file: files that are run or trusted must be ours."""

import os
import pwd
import stat
from pathlib import Path

READ_ONLY = "is on a read-only disk"


def is_safe(path: Path) -> bool:
    """Return whether only root and this user can write `path`, or replace it."""
    return not weakness(path)


def weakness(path: Path) -> str:
    """Return why another user could write or replace `path`; "" when none could."""
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


def why_not_writable(place: Path, needed: int = os.W_OK) -> str:
    """Return why this user may not use what is there, "is on a read-only disk", and the like; "" when he may.

    needed: what he needs beside the right to write, as for `os.access`.
    """
    if os.access(place, needed | os.W_OK):
        return ""
    if os.statvfs(place).f_flag & os.ST_RDONLY:
        return READ_ONLY
    return f"may not be written by user {name_of(os.geteuid())}, as it belongs to {name_of(place.stat().st_uid)}"


def name_of(uid: int) -> str:
    """Return a user's name, or the number of one of another machine."""
    try:
        return pwd.getpwuid(uid).pw_name
    except KeyError:
        return str(uid)
