"""Syncs written data to the disk every few seconds, so that a power failure loses no more than that."""

import os
import threading
from contextlib import suppress

PERIOD_S = 5.0


class Syncer(threading.Thread):
    """Calls fdatasync on the file that is being written, and once more on one that is left."""

    def __init__(self) -> None:
        super().__init__(name="sync", daemon=True)
        self._wake = threading.Event()
        self._lock = threading.Lock()
        self._fds: list[int] = []
        self._ended = False

    def watch(self, fd: int | None) -> None:
        """Look after another file, which may be closed meanwhile, besides the last time for the one before."""
        if fd is not None:
            with self._lock:
                self._fds.append(os.dup(fd))

    def run(self) -> None:
        """Go on until `stop`."""
        while not self._ended:
            self._wake.wait(PERIOD_S)
            with self._lock:
                left, self._fds = self._fds[:-1], self._fds[-1:]
                current = self._fds[:]
            for fd in [*left, *current]:
                with suppress(OSError):
                    os.fdatasync(fd)
            for fd in left:
                os.close(fd)
        for fd in self._fds:
            os.close(fd)

    def stop(self) -> None:
        """Do it a last time."""
        self._ended = True
        self._wake.set()
