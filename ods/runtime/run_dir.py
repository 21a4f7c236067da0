"""The folder where the processes meet: who may be in it, and the locks that keep a second process out.

Its owner runs the processes; its group may read and connect; others may do nothing. A folder that somebody else made,
or could change, is refused: there he would receive and answer in place of a process.
"""

import contextlib
import fcntl
import logging
import os
import pwd
import stat
from collections.abc import Iterator
from pathlib import Path

from ods.base.errors import OdsError

log = logging.getLogger(__name__)

FOLDER_MODE, LOCK_MODE = 0o750, 0o640
FOR_GROUP, FOR_OWNER = 0o660, 0o600
"""Modes of sockets: whoever connects needs the right to write."""


SERVICE_DIR = Path("/run/ods")
"""Where the units run."""


def default_run_dir() -> Path:
    """Return the service's folder for root and if it exists, otherwise one of the user's own."""
    if os.geteuid() == 0 or SERVICE_DIR.is_dir():
        return SERVICE_DIR
    runtime_dir = os.environ.get("XDG_RUNTIME_DIR")
    return Path(runtime_dir, "ods") if runtime_dir else Path(os.environ.get("HOME", "/"), ".local/state/ods/run")


class RunDirError(OdsError):
    """The folder, or a lock in it, cannot be used; the text says why in one line."""


def prepare(run_dir: Path) -> None:
    """Make the folder if need be. Raises RunDirError where another user owns it, or could write in it or replace it."""
    try:
        run_dir.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            run_dir.mkdir(mode=0o700)
            run_dir.chmod(FOLDER_MODE)
        complaint = _complaint(run_dir)
        if complaint is None and run_dir.stat().st_mode & stat.S_IWGRP:
            run_dir.chmod(FOLDER_MODE)
            log.warning("%s: removed the group's write permission for this folder", run_dir)
    except OSError as error:
        raise RunDirError(f"bus.run_dir: cannot use {run_dir}: {error.strerror}") from error
    if complaint is not None:
        raise RunDirError(f"bus.run_dir: {complaint}")


def is_safe_to_hear(run_dir: Path) -> bool:
    """Return whether the folder is there, for one who listens, also as another user than the processes.

    Raises RunDirError where somebody could speak in their place: where `prepare` would, but that the processes' user
    may be another one where root gave him the folder, as the units do.
    """
    try:
        complaint = _complaint(run_dir, _owner_of(run_dir))
    except OSError:  # it comes with the first process, or may not be looked at, which connecting says
        return False
    if complaint is not None:
        raise RunDirError(f"bus.run_dir: {complaint}")
    return True


def _owner_of(run_dir: Path) -> int:
    """Return who may speak there: whose the folder is, unless anybody could have made it, as in /tmp, or the group may
    write in it."""
    state = run_dir.lstat()
    anybodys = run_dir.resolve().parent.stat().st_mode & stat.S_IWOTH or state.st_mode & stat.S_IWGRP
    return os.geteuid() if anybodys and state.st_uid != 0 else state.st_uid


def _complaint(run_dir: Path, owner: int | None = None) -> str | None:
    """Return why another user than `owner`, by default this one, could speak there; None where none could."""
    owner = os.geteuid() if owner is None else owner
    state = run_dir.lstat()
    if stat.S_ISLNK(state.st_mode):
        return f"{run_dir} is a symbolic link: use the folder itself"
    if not stat.S_ISDIR(state.st_mode):
        return f"{run_dir} is not a folder"
    if state.st_uid != owner:
        return (
            f"{run_dir} belongs to {_user(state.st_uid)}, and this runs as {_user(os.geteuid())}: name another folder"
        )
    if state.st_mode & stat.S_IWOTH:
        return f"every user can write in {run_dir}: chmod o-w {run_dir}"
    for place in run_dir.resolve().parents:
        state = place.stat()
        open_to_all = state.st_mode & stat.S_IWOTH and not state.st_mode & stat.S_ISVTX
        if state.st_uid not in (0, os.geteuid()) or open_to_all:
            return f"another user could replace {run_dir}, because others can write to {place}: use another folder"
    return None


def _user(uid: int) -> str:
    try:
        return f"user {pwd.getpwuid(uid).pw_name}"
    except KeyError:
        return f"user {uid}"


@contextlib.contextmanager
def sockets_made(mode: int) -> Iterator[None]:
    """Let sockets that are bound meanwhile have this mode, whatever the umask of the process."""
    before = os.umask(0o777 & ~mode)
    try:
        yield
    finally:
        os.umask(before)


def identity(path: Path) -> tuple[int, int] | None:
    """Return what distinguishes the file at `path` from every other one; None: there is none."""
    try:
        state = path.lstat()
    except OSError:
        return None
    return state.st_dev, state.st_ino


class Lock:
    """The lock of one process, held until `close` or the process's end."""

    def __init__(self, run_dir: Path, process: str) -> None:
        """Take it. Raises RunDirError, where another process has it too."""
        self._run_dir, self._process = run_dir, process
        self._fd = _taken(run_dir, process)

    def restore(self) -> bool:
        """Take it again if its file was removed; return whether it was. Raises RunDirError where another was
        quicker."""
        state = os.fstat(self._fd)
        if identity(self._run_dir / f"{self._process}.lock") == (state.st_dev, state.st_ino):
            return False
        stale, self._fd = self._fd, _taken(self._run_dir, self._process)
        os.close(stale)
        return True

    def write(self, content: bytes) -> None:
        """Let its file have this content. Raises OSError."""
        os.ftruncate(self._fd, 0)
        os.pwrite(self._fd, content, 0)

    def close(self) -> None:
        """Give it back."""
        os.close(self._fd)


def _taken(run_dir: Path, process: str) -> int:
    """Return the open file of a lock that is ours. Raises RunDirError."""
    prepare(run_dir)
    path = run_dir / f"{process}.lock"
    try:
        fd = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, LOCK_MODE)
    except OSError as error:
        raise RunDirError(f"bus.run_dir: cannot use {path}: {error.strerror}") from error
    try:
        _refuse_foreign(fd, path)
        os.fchmod(fd, LOCK_MODE)
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(fd)
        raise RunDirError(f"another `ods {process}` already runs on {run_dir}") from error
    except RunDirError:
        os.close(fd)
        raise
    return fd


def _refuse_foreign(fd: int, path: Path) -> None:
    """Raises RunDirError where the open file is not our own, or has a second name: it is somebody's data."""
    state = os.fstat(fd)
    if not stat.S_ISREG(state.st_mode) or state.st_uid != os.geteuid() or state.st_nlink > 1:
        raise RunDirError(f"bus.run_dir: {path} is not a lock of {_user(os.geteuid())}: remove it")


def is_locked(run_dir: Path, process: str) -> bool:
    """Return whether a process holds its lock."""
    try:
        fd = os.open(run_dir / f"{process}.lock", os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return False
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(fd)
    return False
