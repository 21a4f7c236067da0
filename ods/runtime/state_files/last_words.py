"""Why a process ended, left in the run folder for the tracker: under systemd nobody else tells it to the planner.

The words stand in the process's lock file, which nobody else may write; they count only while the lock is free.
"""

import contextlib
import os
from pathlib import Path

from ods.runtime.run_dir import Lock, RunDirError, is_locked

LONGEST_WORDS = 500
"""Characters of the reason that a process gives when it ends."""


def leave(run_dir: Path, process: str, words: str) -> None:
    """Leave the reason why a process ends, "" for none; in vain where there is no folder or the process runs."""
    if not os.path.isdir(run_dir):  # noqa: PTH112  which never raises
        return
    with contextlib.suppress(RunDirError, OSError):
        lock = Lock(run_dir, process)
        try:
            lock.write(words[:LONGEST_WORDS].encode())
        finally:
            lock.close()


def left(run_dir: Path, process: str) -> str:
    """Return why a process ended last, "" when it runs or nothing is known."""
    if is_locked(run_dir, process):
        return ""
    try:
        fd = os.open(run_dir / f"{process}.lock", os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return ""
    try:
        words = os.read(fd, 4 * LONGEST_WORDS).decode(errors="replace")
    except OSError:
        return ""
    finally:
        os.close(fd)
    return "".join(c if c.isprintable() else " " for c in words)
