"""Writes kept files on a thread of its own: where the run folder is on a disk that stalls, only the thread waits."""

import queue
import threading

from ods.runtime.kept_file import KeptFile

WITHIN_S = 0.1
"""A write in memory takes less than a millisecond."""


class StalledError(OSError):
    """The disk of the run folder does not answer."""


class _Job:
    def __init__(self, file: KeptFile, content: bytes) -> None:
        self.file, self.content = file, content
        self.error: OSError | None = None
        self.done = threading.Event()


class KeptWriter:
    """Writes one content at a time, and waits for it, but not for ever."""

    def __init__(self) -> None:
        self._jobs: queue.SimpleQueue[_Job] = queue.SimpleQueue()
        self._newest: _Job | None = None

    def write(self, file: KeptFile, content: bytes) -> None:
        """Replace a file's content. Raises OSError; StalledError also at once, while an earlier write is under way."""
        if self._newest is None:
            threading.Thread(target=self._work, name="kept files", daemon=True).start()
        elif not self._newest.done.is_set():
            raise StalledError("the disk of the run folder does not answer")
        self._newest = job = _Job(file, content)
        self._jobs.put(job)
        if not job.done.wait(WITHIN_S):
            raise StalledError("the disk of the run folder does not answer")
        if job.error is not None:
            raise job.error

    def _work(self) -> None:
        while True:
            job = self._jobs.get()
            try:
                job.file.write(job.content)
            except OSError as error:
                job.error = error
            job.done.set()
