"""Reason why a process ended, in the run folder, for the tracker: under systemd nothing else reports it.

It is stored in the process's lock file, which no other process may write; it counts only while the lock is free.
"""

import contextlib
import os
from pathlib import Path

from ods.runtime.run_dir import Lock, RunDirError, is_locked

LONGEST_WORDS = 500
"""Characters of the reason that a process gives when it ends."""


def write(run_dir: Path, process: str, words: str) -> None:
    """Write the reason why a process ends, "" for none; nothing happens if there is no folder or the process runs."""
    if not os.path.isdir(run_dir):  # noqa: PTH112  which never raises
        return
    with contextlib.suppress(RunDirError, OSError):
        lock = Lock(run_dir, process)
        try:
            lock.write(words[:LONGEST_WORDS].encode())
        finally:
            lock.close()


def read(run_dir: Path, process: str) -> str:
    """Return why a process last ended; "" if it runs or no reason is known."""
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
