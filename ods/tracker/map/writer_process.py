"""The map's process, as the tracker sees it: started, started again when it ended, talked to, and left alone."""

import select
import socket
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path

from ods.base.clock import NS
from ods.base.computer.overload import OverloadMonitor
from ods.runtime.port.backoff import Backoff
from ods.tracker.map.link import FIRST_DELAY_S, LONGEST_DELAY_S, Change, Link, LinkEndedError, Message


class WriterProcess:
    """Nothing here waits, but `finish`, for at most the time given. Where none runs there is nothing to receive."""

    def __init__(self, path: Path, origin_deg: tuple[float, float], run_dir: Path) -> None:
        self._command = [sys.executable, "-P", "-m", "ods.tracker.map.writer", str(path)]
        self._command += [*map(repr, origin_deg), str(run_dir)]
        self._backoff = Backoff(FIRST_DELAY_S, LONGEST_DELAY_S)
        self._process: subprocess.Popen[bytes] | None = None
        self._link: Link | None = None
        self._start_ns = 0
        self._overload: OverloadMonitor | None = None
        self._looked_ns = 0

    def start(self, now_ns: int) -> bool:
        """Start it if it is time to; return whether it was. Raises LinkEndedError."""
        if self._link is not None or now_ns < self._start_ns:
            return False
        try:
            ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            ours.setblocking(False)
            self._link = Link(ours)
            with theirs:
                # its own group: a Ctrl-C while it still imports would end it with a traceback
                self._process = subprocess.Popen(self._command, stdin=theirs.fileno(), process_group=0)
        except OSError as error:
            raise LinkEndedError(error.strerror) from error
        self._overload, self._looked_ns = OverloadMonitor(self._process.pid), now_ns
        self._overload.look(now_ns)
        return True

    def starved(self, now_ns: int) -> str:
        """Return one line if it gets too little of a processor, "" if not; asked often, it looks once a second."""
        if self._overload is None:
            return ""
        if now_ns - self._looked_ns > NS:
            self._looked_ns = now_ns
            self._overload.look(now_ns)
        return self._overload.starved(now_ns)

    def works(self) -> None:
        """It has opened the file: when it ends now, it is started again soon."""
        self._backoff.worked()

    def lost(self, now_ns: int) -> None:
        """It has ended: start it again later."""
        if self._link is not None:
            self._link.close()
        if self._process is not None:
            self._process.poll()
        self._link = self._process = None
        self._start_ns = now_ns + round(self._backoff.failed() * NS)

    def send(self, change: Change) -> bool:
        """Send a change; False when there is no room for it just now. Raises LinkEndedError."""
        return self._link is not None and self._link.send(change)

    def receive(self) -> Message | None:
        """Return what it says next; None when it says nothing just now. Raises LinkEndedError."""
        return None if self._link is None else self._link.receive()

    def finish(self, changes: Iterable[Change], within_s: float) -> list[Message] | None:
        """Hand it its last changes and wait for its end: return what it said. None: it goes on by itself, or died."""
        if self._link is None:
            return None
        link, deadline_s = self._link, time.monotonic() + within_s
        said: list[Message] = []
        try:
            for change in changes:
                while not link.send(change):
                    if not _ready(link, select.POLLIN | select.POLLOUT, deadline_s):
                        return None
                    said += _waiting(link)
        except LinkEndedError:
            return None
        link.end()
        try:
            while _ready(link, select.POLLIN, deadline_s):
                said += _waiting(link)
        except LinkEndedError:
            return said
        return None


def _waiting(link: Link) -> list[Message]:
    """Raises LinkEndedError."""
    said = []
    while message := link.receive():
        said.append(message)
    return said


def _ready(link: Link, events: int, deadline_s: float) -> bool:
    poller = select.poll()
    poller.register(link.fileno(), events)
    return bool(poller.poll(max(0.0, 1e3 * (deadline_s - time.monotonic()))))
