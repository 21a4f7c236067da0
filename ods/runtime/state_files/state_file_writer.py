"""Writes state files on a separate thread: if the run folder is on a disk that stalls, only that thread waits."""

import queue
import threading

from ods.base.computer.overload import OVERLOADED, waits_for_processor
from ods.runtime.state_files.state_file import StateFile

WITHIN_S = 0.1
"""A write in memory takes less than a millisecond."""


class StalledError(OSError):
    """The disk of the run folder does not answer, or the thread that writes to it gets no processor."""


class _Job:
    def __init__(self, file: StateFile, content: bytes) -> None:
        self.file, self.content = file, content
        self.error: OSError | None = None
        self.done = threading.Event()


class StateFileWriter:
    """Writes one content at a time, and waits for it, but not for ever."""

    def __init__(self) -> None:
        self._jobs: queue.SimpleQueue[_Job] = queue.SimpleQueue()
        self._newest: _Job | None = None
        self._thread: threading.Thread | None = None

    def write(self, file: StateFile, content: bytes) -> None:
        """Replace a file's content. Raises OSError; StalledError also at once, while an earlier write is under way."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="kept files", daemon=True)
            self._thread.start()
        elif self._newest is not None and not self._newest.done.is_set():
            raise self._stalled(self._thread)
        self._newest = job = _Job(file, content)
        self._jobs.put(job)
        if not job.done.wait(WITHIN_S):
            raise self._stalled(self._thread)
        if job.error is not None:
            raise job.error

    @staticmethod
    def _stalled(thread: threading.Thread) -> StalledError:
        waits = thread.native_id is None or waits_for_processor(thread.native_id)
        return StalledError(OVERLOADED if waits else "the disk of the run folder does not respond")

    def _work(self) -> None:
        while True:
            job = self._jobs.get()
            try:
                job.file.write(job.content)
            except OSError as error:
                job.error = error
            job.done.set()
