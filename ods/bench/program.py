"""One `ods` command that the bench runs beside itself."""

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Self

import psutil

from ods.base.errors import OdsError
from ods.runtime.ending import SUPERVISOR_PID


class BenchError(OdsError):
    """The bench could not run; the text says why."""


class Program:
    """A running `ods COMMAND --config FILE`, ended when the `with` block is, or the bench killed.

    What it says goes to `log_file`.
    """

    def __init__(self, command: str, config: Path, log_file: Path) -> None:
        self.log_file = log_file
        self._command = [sys.executable, "-P", "-m", "ods", command, "--config", str(config)]
        self._again_s = math.inf
        """When one that was killed starts again."""
        log_file.write_bytes(b"")
        self._start()

    def _start(self) -> None:
        with self.log_file.open("ab") as log:
            self._process = subprocess.Popen(
                self._command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=os.environ | {SUPERVISOR_PID: str(os.getpid())},
            )

    def restart(self, after_s: float) -> None:
        """Kill it; `check` starts it again once that time has passed."""
        self._process.kill()
        self._process.wait()
        self._again_s = time.monotonic() + after_s

    def check(self) -> None:
        """Raise BenchError, with its last words, if it has ended; start it again if it was killed for that."""
        if time.monotonic() >= self._again_s:
            self._again_s = math.inf
            self._start()
        if self._process.poll() is not None and math.isinf(self._again_s):
            lines = self.log_file.read_text(errors="replace").strip().splitlines()
            raise BenchError(f"{lines[-1] if lines else 'a process ended'} (see {self.log_file})")

    def children(self, name: str) -> list[psutil.Process]:
        """Return its child processes that run `ods NAME`."""
        return [child for child in psutil.Process(self._process.pid).children() if name in child.cmdline()]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.send_signal(signal.SIGTERM)
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
