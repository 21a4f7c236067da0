"""`ods run`: keeps the on-board processes up.

Each child talks the sd_notify protocol to a socket of its own, as it would under systemd: READY=1 once it works,
WATCHDOG=1 from its work loop, STOPPING=1 with STATUS= why when it gives up. A child that ends, or whose loop hangs, is
started again with a growing delay, without end: what is wrong may be repaired meanwhile,
and the others go on. While one is down its health is reported here, so that the obstacle list can say why.
"""

import logging
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import zmq

from ods.base import clock
from ods.base.computer.overload import STARVED, ProcessorTime, is_starved, processor_time
from ods.base.errors import reason_of
from ods.base.settings import NonNegative, Positive, Settings
from ods.messages import Health
from ods.runtime import bus
from ods.runtime.ending import SUPERVISOR_PID, end_with_supervisor
from ods.runtime.port.backoff import Backoff
from ods.runtime.processes import SUPERVISOR, Process
from ods.runtime.run_dir import FOR_OWNER, identity, prepare, sockets_made
from ods.runtime.service import notify

log = logging.getLogger(__name__)

POLL_S = 0.05
GONE_S = 0.5
"""A killed process is gone sooner, unless the kernel waits in it for a disk or a device: that may take for ever."""
HELD = "killed, but still waiting for a disk or device that does not respond"
AT_WORK = 0.05
"""Share of the time: a process that runs or waits for a processor for longer while it starts is at work."""
MOST_WATCHDOGS = 10
"""A work loop that gets no processor is killed all the same after this many times `watchdog_s`."""


class SuperviseSettings(Settings, frozen=True):
    """Restarting processes that ended or hang."""

    first_delay_s: NonNegative = 0.1
    """Before the first restart; doubled each time up to `longest_delay_s`."""
    longest_delay_s: NonNegative = 5.0
    settled_s: Positive = 60.0
    """After this running time the delay is reset to `first_delay_s`."""
    start_s: Positive = 30.0
    """Longest time to the first watchdog message; doubled for a process that uses or waits for a processor."""
    watchdog_s: Positive = 3.0
    """Longest time without a watchdog message; ten times as long while the process waits for a processor."""
    stop_s: Positive = 1.5
    """From SIGTERM to SIGKILL."""


class Child:
    """One supervised process."""

    def __init__(self, process: Process, command: Sequence[str], run_dir: Path, settings: SuperviseSettings) -> None:
        self.name = process.name
        self.ready = False
        self.down = ""
        """Why its work loop does not run, once it has ended; '' while it does."""
        self.busy = ""
        """Why it sends no watchdog message although it has no fault of its own."""
        self._command = list(command)
        self._settings = settings
        self._backoff = Backoff(settings.first_delay_s, settings.longest_delay_s)
        self._last_words = ""
        self._killed = False
        self._popen: subprocess.Popen[bytes] | None = None
        self._start_at = self._started_at = 0.0
        self._alive_until = 0.0
        self._sign_at = 0.0
        """When it sent its last watchdog message, or was started."""
        self._looked_at = 0.0
        """When its processor time was last read."""
        self._spent = ProcessorTime(0, 0)
        """which was this."""
        self._has_lived = False
        """It has sent a watchdog message since it was started."""
        self._address = run_dir / f"{process.name}.notify"
        self._bind()

    def _bind(self) -> None:
        """Raises RunDirError."""
        prepare(self._address.parent)
        self._address.unlink(missing_ok=True)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        with sockets_made(FOR_OWNER):
            self._socket.bind(str(self._address))
        self._identity = identity(self._address)

    def step(self, now_s: float) -> None:
        """Perform due actions: start, receive, detect the end or a hang."""
        if self._popen is None:
            if now_s >= self._start_at:
                self._start(now_s)
            return
        if not self._killed:
            self._listen(now_s)
        code = self._popen.poll()
        if code is not None:
            self._ended(code, now_s)
        elif now_s > self._alive_until and not self._killed and not self._may_go_on(self._popen.pid, now_s):
            log.error("%s sent no watchdog message in time: killed", self.name)
            self._last_words = "it sent no watchdog message in time"
            self._kill(self._popen, now_s)

    def _may_go_on(self, pid: int, now_s: float) -> bool:
        """Return whether a silent process is at work or starved rather than hung; then wait longer for it."""
        settings, now = self._settings, processor_time(pid)
        spent, within_ns = now.since(self._spent), round((now_s - self._looked_at) * clock.NS)
        starved = is_starved(spent, within_ns)
        if self._has_lived:
            goes_on = starved and now_s - self._sign_at < MOST_WATCHDOGS * settings.watchdog_s
            more_s = settings.watchdog_s
        else:
            goes_on = spent.total_ns > AT_WORK * within_ns
            more_s = settings.start_s
        if goes_on:
            self._spent, self._looked_at, self._alive_until = now, now_s, now_s + more_s
            if not self.busy:
                log.warning(
                    "%s has sent no watchdog message yet, %s",
                    self.name,
                    STARVED if starved else "but it uses the processor",
                )
            self.busy = STARVED if starved else f"is starting, for {now_s - self._started_at:.0f} s"
        return goes_on

    def _kill(self, popen: "subprocess.Popen[bytes]", now_s: float) -> None:
        """Kill it; one that is not gone at once is not waited for: the others are looked after meanwhile."""
        self._killed = True
        popen.kill()
        try:
            self._ended(popen.wait(GONE_S), now_s)
        except subprocess.TimeoutExpired:
            self.ready, self.busy, self.down = False, "", HELD if _waits_for_device(popen.pid) else f"killed; {STARVED}"
            log.error("%s %s: restarting it once it has ended", self.name, self.down)

    def _start(self, now_s: float) -> None:
        environment = os.environ | {"NOTIFY_SOCKET": str(self._address), SUPERVISOR_PID: str(os.getpid())}
        try:
            self._popen = subprocess.Popen(self._command, stdin=subprocess.DEVNULL, env=environment)
        except OSError as error:  # no memory, no process or descriptor left: that may pass
            self._start_at = now_s + self._backoff.failed()
            self.down = f"cannot be started: {reason_of(error)}"
            log.error("%s %s: trying again in %.1f s", self.name, self.down, self._start_at - now_s)
            return
        self._started_at = self._sign_at = self._looked_at = now_s
        self._alive_until = now_s + self._settings.start_s
        self._spent = ProcessorTime(0, 0)
        self._has_lived = False
        self._last_words = ""
        self._killed = False
        log.info("%s started (pid %d)", self.name, self._popen.pid)

    def _listen(self, now_s: float) -> None:
        if identity(self._address) != self._identity:
            log.warning("%s had been removed; created it again", self._address)
            self._socket.close()
            self._bind()
        while True:
            try:
                text = self._socket.recv(4096).decode(errors="replace")
            except BlockingIOError:
                return
            if "READY=1" in text:
                self.ready = True
            if "WATCHDOG=1" in text:
                self._lives(now_s)
            if "STOPPING=1" in text:
                self._last_words = text.partition("STATUS=")[2]

    def _lives(self, now_s: float) -> None:
        """Record a watchdog message."""
        self._sign_at = self._looked_at = now_s
        self._alive_until = now_s + self._settings.watchdog_s
        self._spent = processor_time(self.pid)
        self._has_lived = True
        self.down = self.busy = ""

    @property
    def pid(self) -> int:
        """Of the process; 0 when there is none."""
        return self._popen.pid if self._popen else 0

    def _ended(self, code: int, now_s: float) -> None:
        self._listen(now_s)
        self._popen = None
        self.ready = False
        self.busy = ""
        if now_s - self._started_at >= self._settings.settled_s:
            self._backoff.worked()
        self._start_at = now_s + self._backoff.failed()
        self.down = f"killed by signal {-code}" if code < 0 else f"ended with code {code}"
        if self._last_words:
            self.down += f": {self._last_words}"
        log.error("%s %s: restarting it in %.1f s", self.name, self.down, self._start_at - now_s)

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
                self._await_end(self._popen)
            self._popen = None
        self._socket.close()
        self._address.unlink(missing_ok=True)

    def _await_end(self, popen: "subprocess.Popen[bytes]") -> None:
        try:
            popen.wait(GONE_S)
        except subprocess.TimeoutExpired:
            log.error("%s %s: pid %d keeps running", self.name, HELD, popen.pid)


def _waits_for_device(pid: int) -> bool:
    """Return whether the kernel waits in a process for a disk or a device, rather than the process for a processor."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "R"
    except (OSError, IndexError):
        return True


class _OwnTime:
    """Time in which the supervisor runs: while it is stopped, its children may be too, and none is silent for it."""

    def __init__(self) -> None:
        self._now_s = self._looked_s = time.monotonic()

    def now_s(self) -> float:
        """Return it, s; more than a period of signs of life since the last call means that it was stopped."""
        looked_s = time.monotonic()
        self._now_s += min(looked_s - self._looked_s, bus.HEALTH_PERIOD_S)
        self._looked_s = looked_s
        return self._now_s


class _Reporter:
    """Reports the health of the children that are down, or busy before they can report it themselves."""

    def __init__(self, run_dir: Path) -> None:
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context(1)
        self._publisher = bus.Publisher(self._context, run_dir, SUPERVISOR)
        self._seq = 0
        self._due_s = 0.0

    def report(self, children: Sequence[Child], now_s: float) -> None:
        """Publish what is due."""
        if now_s < self._due_s:
            return
        self._due_s = now_s + bus.HEALTH_PERIOD_S
        if self._publisher.restore():
            log.warning("lock or socket of `ods run` had been removed; created them again")
        for child in children:
            if child.down or child.busy:
                self._publisher.publish(bus.HEALTH, _health(child, self._seq))
                self._seq += 1

    def close(self) -> None:
        """Give socket and lock back."""
        self._publisher.close()
        self._context.term()


def _health(child: Child, seq: int) -> Health:
    now = clock.monotonic_ns()
    return Health(
        process=child.name,
        pid=child.pid,
        seq=seq,
        t_ns=now,
        utc_ns=clock.utc_ns(now),
        ready=False,
        problems=[child.busy or child.down],
        counters={},
        rates_hz={},
        ages_s={},
        lags={},
        cpu_percent=0.0,
        rss_mb=0.0,
    )


def supervise(processes: Sequence[Process], config: Path, run_dir: Path, settings: SuperviseSettings) -> None:
    """Keep `processes` up until SIGTERM or SIGINT. Raises OdsError, before it starts any."""
    end_with_supervisor()
    stopping: list[int] = []

    def handler(number: int, _frame: Any) -> None:
        stopping.append(number)

    signal.signal(signal.SIGTERM, handler)
    signal.signal(signal.SIGINT, handler)
    level = logging.getLevelName(logging.getLogger().level).lower()
    reporter = _Reporter(run_dir)
    log.info("sockets are in %s", run_dir)
    children = [Child(process, _command(process, config, level), run_dir, settings) for process in processes]
    announced, own_time = False, _OwnTime()
    try:
        while not stopping:
            now_s = own_time.now_s()
            for child in children:
                child.step(now_s)
            reporter.report(children, now_s)
            if not announced and all(child.ready for child in children):
                announced = True
                log.info("all processes are ready")
                notify("READY=1")
            notify("WATCHDOG=1")
            time.sleep(POLL_S)
    finally:
        _stop(children, settings.stop_s)
        reporter.close()


def _stop(children: Sequence[Child], within_s: float) -> None:
    for child in children:
        child.terminate()
    deadline_s = time.monotonic() + within_s
    for child in children:
        child.reap(deadline_s)


def _command(process: Process, config: Path, log_level: str) -> list[str]:
    safe_path = "-P"  # or whoever can write in the current folder has his numpy.py run
    options = ["--config", str(config), "--log-level", log_level]
    return [sys.executable, safe_path, "-m", "ods", *process.command.split(), *options]
