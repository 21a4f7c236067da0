"""Writes log lines to standard error without blocking: work continues while a terminal is stopped (Ctrl-S, an ssh
session
that stalls) or a pipe is not read."""

import atexit
import logging
import os
from contextlib import suppress
from queue import Full, Queue
from threading import Thread

STDERR = 2
MOST_LINES = 1000
"""That wait; more are lost, and counted."""
AT_THE_END_S = 0.5
"""For what waits to be written when the process ends."""


class LogWriter(logging.Handler):
    """Writes in a thread of its own, past Python's buffers: their lock would be waited for at the end."""

    def __init__(self) -> None:
        super().__init__()
        self._lines: Queue[str | None] = Queue(MOST_LINES)
        self._lost = 0
        self._thread = Thread(target=self._write, name="log", daemon=True)
        self._thread.start()
        atexit.register(self._end)

    def emit(self, record: logging.LogRecord) -> None:
        """Let a line wait for its turn."""
        try:
            self._lines.put_nowait(self.format(record))
        except Full:
            self._lost += 1

    def _write(self) -> None:
        while (line := self._lines.get()) is not None:
            lost, self._lost = self._lost, 0
            text = f"{line}\n{lost} log lines were lost, as standard error was blocked\n" if lost else f"{line}\n"
            left = text.encode(errors="backslashreplace")
            with suppress(OSError):  # closed, or a full disk: there is no other place to report it
                while left:
                    left = left[os.write(STDERR, left) :]

    def _end(self) -> None:
        with suppress(Full):
            self._lines.put_nowait(None)
            self._thread.join(AT_THE_END_S)
