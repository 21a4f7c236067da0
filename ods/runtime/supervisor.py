"""`ods run`: keeps the on-board processes up.

Each child talks the sd_notify protocol to a socket of its own, as it would under systemd: READY=1 once it works,
WATCHDOG=1 from its work loop. A child that ends, or whose loop hangs, is started again with a growing delay; one that
cannot be kept up, or says by exit code 2 that trying again is useless, ends the run with a reason.
"""

import logging
import os
import signal
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ods.base.backoff import Backoff
from ods.base.errors import OdsError
from ods.base.settings import NonNegative, Positive, PositiveInt, Settings
from ods.runtime.processes import Process
from ods.runtime.run_dir import FOR_OWNER, prepare, sockets_made
from ods.runtime.service import notify

log = logging.getLogger(__name__)

USELESS_TO_RETRY = 2
POLL_S = 0.05


class SuperviseSettings(Settings, frozen=True):
    """How hard to try."""

    first_delay_s: NonNegative = 0.1
    """Wait before the first restart; each further one waits twice as long."""
    longest_delay_s: NonNegative = 5.0
    restarts: PositiveInt = 8
    """Restarts of one process within `window_s` after which it counts as impossible to keep up."""
    window_s: Positive = 60.0
    start_s: Positive = 120.0
    """Time for a first sign of life; the first start compiles."""
    watchdog_s: Positive = 3.0
    """Silence of a work loop that counts as hung."""
    stop_s: Positive = 1.5
    """Time to stop by SIGTERM before SIGKILL."""


class CannotKeepUpError(OdsError):
    """A process could not be kept up; the text says which and why."""


class RestartPolicy:
    """Back-off and rate limit of one process. Pure: the caller gives the time."""

    def __init__(self, settings: SuperviseSettings) -> None:
        self._settings = settings
        self._backoff = Backoff(settings.first_delay_s, settings.longest_delay_s)
        self._restarts: deque[float] = deque()

    def delay(self, now_s: float) -> float | None:
        """Return how long to wait before this restart, None when there were too many."""
        while self._restarts and now_s - self._restarts[0] > self._settings.window_s:
            self._restarts.popleft()
        if len(self._restarts) >= self._settings.restarts:
            return None
        self._restarts.append(now_s)
        return self._backoff.delay_s(len(self._restarts))


class Child:
    """One supervised process."""

    def __init__(self, process: Process, command: Sequence[str], run_dir: Path, settings: SuperviseSettings) -> None:
        self.name = process.name
        self.ready = False
        self._command = list(command)
        self._settings = settings
        self._policy = RestartPolicy(settings)
        self._popen: subprocess.Popen[bytes] | None = None
        self._start_at = 0.0
        self._alive_until = 0.0
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._address = run_dir / f"{process.name}.notify"
        self._address.unlink(missing_ok=True)
        with sockets_made(FOR_OWNER):
            self._socket.bind(str(self._address))

    def step(self, now_s: float) -> None:
        """Do what is due: start, listen, notice the end or a hang. Raises CannotKeepUpError."""
        if self._popen is None:
            if now_s >= self._start_at:
                self._start(now_s)
            return
        self._listen(now_s)
        code = self._popen.poll()
        if code is not None:
            self._ended(code, now_s)
        elif now_s > self._alive_until:
            log.error("%s shows no sign of life: killed", self.name)
            self._popen.kill()
            self._popen.wait()
            self._ended(-signal.SIGKILL, now_s)

    def _start(self, now_s: float) -> None:
        environment = os.environ | {"NOTIFY_SOCKET": str(self._address), "ODS_SUPERVISOR_PID": str(os.getpid())}
        self._popen = subprocess.Popen(self._command, stdin=subprocess.DEVNULL, env=environment)
        self._alive_until = now_s + self._settings.start_s
        log.info("%s started (pid %d)", self.name, self._popen.pid)

    def _listen(self, now_s: float) -> None:
        while True:
            try:
                text = self._socket.recv(4096).decode(errors="replace")
            except BlockingIOError:
                return
            if "READY=1" in text:
                self.ready = True
            if "WATCHDOG=1" in text:
                self._alive_until = now_s + self._settings.watchdog_s

    def _ended(self, code: int, now_s: float) -> None:
        self._popen = None
        self.ready = False
        if code == USELESS_TO_RETRY:
            raise CannotKeepUpError(f"{self.name} cannot work; its own line above says why")
        how = f"was killed by signal {-code}" if code < 0 else f"ended with code {code}"
        delay = self._policy.delay(now_s)
        if delay is None:
            settings = self._settings
            raise CannotKeepUpError(
                f"{self.name} cannot be kept up: {how}, {settings.restarts} restarts within {settings.window_s:g} s"
            )
        log.error("%s %s: starting it again in %.1f s", self.name, how, delay)
        self._start_at = now_s + delay

    def terminate(self) -> None:
        """Ask it to stop."""
        if self._popen is not None:
            self._popen.terminate()

    def reap(self, deadline_s: float) -> None:
        """Wait for its end until the monotonic time `deadline_s`, then kill it."""
        if self._popen is not None:
            try:
                self._popen.wait(max(0.0, deadline_s - time.monotonic()))
            except subprocess.TimeoutExpired:
                log.error("%s did not stop in time: killed", self.name)
                self._popen.kill()
                self._popen.wait()
            self._popen = None
        self._socket.close()
        self._address.unlink(missing_ok=True)


def supervise(processes: Sequence[Process], config: Path, run_dir: Path, settings: SuperviseSettings) -> None:
    """Keep `processes` up until SIGTERM or SIGINT. Raises CannotKeepUpError after stopping the others."""
    stopping: list[int] = []

    def handler(number: int, _frame: Any) -> None:
        stopping.append(number)

    signal.signal(signal.SIGTERM, handler)
    signal.signal(signal.SIGINT, handler)
    level = logging.getLevelName(logging.getLogger().level).lower()
    prepare(run_dir)
    children = [Child(process, _command(process, config, level), run_dir, settings) for process in processes]
    announced = False
    try:
        while not stopping:
            for child in children:
                child.step(time.monotonic())
            if not announced and all(child.ready for child in children):
                announced = True
                log.info("all processes are ready")
                notify("READY=1")
            notify("WATCHDOG=1")
            time.sleep(POLL_S)
    finally:
        for child in children:
            child.terminate()
        deadline_s = time.monotonic() + settings.stop_s
        for child in children:
            child.reap(deadline_s)


def _command(process: Process, config: Path, log_level: str) -> list[str]:
    safe_path = "-P"  # or whoever can write in the current folder has his numpy.py run
    return [sys.executable, safe_path, "-m", "ods", process.name, "--config", str(config), "--log-level", log_level]
