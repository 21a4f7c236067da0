"""A CAN bus made of pseudo-terminals, for machines whose kernel has no vcan.

Each port is the device end of an slcan (LAWICEL) adapter: python-can and Linux's slcand open it like a real one.
"""

import contextlib
import logging
import os
import re
import select
import termios
import threading
import tty
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from queue import SimpleQueue
from types import TracebackType

log = logging.getLogger(__name__)

CR, BELL = b"\r", b"\a"
FRAME_HEAD = re.compile(rb"(?:[tr][0-7][0-9A-Fa-f]{2}|[TR][01][0-9A-Fa-f]{7})([0-8])([0-9A-Fa-f]*)")
ANSWERS = {b"V": b"V1013\r", b"v": b"v1013\r", b"N": b"NHUB0\r", b"F": b"F00\r"}
SETTINGS = b"SsZMmXY"
"""Commands that set what a virtual bus has not got: bit rate, time stamps, filters."""
MAX_LINE = 64
MAX_PENDING = 16384
"""Bytes kept for a client that does not read; about half a second of a busy bus."""
SETTLE_MS = 2


def is_frame(line: bytes) -> bool:
    """Return whether an slcan line, without its carriage return, is a well-formed classical CAN frame."""
    match = FRAME_HEAD.fullmatch(line)
    return match is not None and len(match[2]) == (2 * int(match[1]) if line[:1] in b"tT" else 0)


class _Port:
    """One pty: the hub holds both ends, so that a client may come and go."""

    def __init__(self, link: Path) -> None:
        self.link = link
        self.master = self.slave = -1
        self.on_bus = False
        self.received = bytearray()
        self.pending = bytearray()

    def plug(self) -> None:
        self.unplug()
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        os.set_blocking(self.master, False)
        self.link.parent.mkdir(parents=True, exist_ok=True)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(self.slave))

    def unplug(self) -> None:
        if self.master < 0:
            return
        self.link.unlink(missing_ok=True)
        os.close(self.slave)
        os.close(self.master)
        self.master = self.slave = -1
        self.on_bus = False
        self.received.clear()
        self.pending.clear()

    def read_lines(self) -> list[bytes]:
        """Return complete lines, without their carriage returns; an endless one is cut."""
        with contextlib.suppress(BlockingIOError):
            self.received += os.read(self.master, 65536)
        *lines, rest = bytes(self.received).split(CR)
        if len(rest) > MAX_LINE:
            lines, rest = [*lines, rest], b""
        self.received[:] = rest
        return lines

    def send(self, data: bytes) -> bool:
        """Queue and write; False when the client has not read for too long and `data` is dropped."""
        fits = len(self.pending) + len(data) <= MAX_PENDING
        if fits:
            self.pending += data
        self.flush()
        return fits

    def flush(self) -> None:
        with contextlib.suppress(BlockingIOError):
            del self.pending[: os.write(self.master, self.pending)]

    def forget(self) -> None:
        """Drop what an earlier client left unread."""
        self.pending.clear()
        termios.tcflush(self.slave, termios.TCIFLUSH)
        unread = select.poll()
        unread.register(self.slave, select.POLLIN)
        while unread.poll(SETTLE_MS):
            os.read(self.slave, 65536)


class SlcanHub:
    """A bus with one port a link. A frame sent on one open port appears on all other open ones.

    Runs a thread of its own from construction to `close`. `counters`: `frames`, `garbage` (lines that are neither
    frame nor command), `refused` (frames sent on a closed port), `dropped` (lines a client did not read in time).
    """

    def __init__(self, links: Sequence[Path]) -> None:
        self.counters: Counter[str] = Counter()
        self.links = tuple(links)
        self._ports = [_Port(link) for link in links]
        self._jobs: SimpleQueue[tuple[Callable[[], None], threading.Event]] = SimpleQueue()
        self._wake = os.eventfd(0, os.EFD_NONBLOCK)
        self._running = True
        for port in self._ports:
            port.plug()
        self._thread = threading.Thread(target=self._run, name="slcan hub", daemon=True)
        self._thread.start()

    def __enter__(self) -> "SlcanHub":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def plug(self, port: int) -> None:
        """Make the device of `port` (index into the links) appear."""
        self._call(self._ports[port].plug)

    def unplug(self, port: int) -> None:
        """Make the device of `port` vanish, as an adapter pulled out."""
        self._call(self._ports[port].unplug)

    def close(self) -> None:
        """Stop the thread and remove all devices."""
        if not self._running:
            return
        self._call(self._stop)
        self._thread.join()
        for port in self._ports:
            port.unplug()
        os.close(self._wake)

    def _stop(self) -> None:
        self._running = False

    def _call(self, job: Callable[[], None]) -> None:
        """Run `job` in the hub's thread, which alone touches the ports."""
        done = threading.Event()
        self._jobs.put((job, done))
        os.eventfd_write(self._wake, 1)
        done.wait()

    def _run(self) -> None:
        while self._running:
            plugged = {port.master: port for port in self._ports if port.master >= 0}
            poller = select.poll()
            poller.register(self._wake, select.POLLIN)
            for fd, port in plugged.items():
                poller.register(fd, select.POLLIN | (select.POLLOUT if port.pending else 0))
            for fd, events in poller.poll():
                if fd == self._wake:
                    self._work()
                elif plugged[fd].master == fd:  # not unplugged a moment ago
                    self._serve(plugged[fd], events)

    def _work(self) -> None:
        os.eventfd_read(self._wake)
        while not self._jobs.empty():
            job, done = self._jobs.get()
            try:
                job()
            except OSError as error:
                log.warning("slcan hub: %s", error)
            finally:
                done.set()

    def _serve(self, port: _Port, events: int) -> None:
        if events & select.POLLOUT:
            port.flush()
        if not events & select.POLLIN:
            return
        frames = [line for line in port.read_lines() if self._is_traffic(port, line)]
        if not frames:
            return
        self.counters["frames"] += len(frames)
        data = CR.join(frames) + CR
        for other in self._ports:
            if other is not port and other.on_bus and not other.send(data):
                self.counters["dropped"] += len(frames)

    def _is_traffic(self, port: _Port, line: bytes) -> bool:
        """Return whether a line is a frame for the bus; answer it when it is a command."""
        if is_frame(line):
            self.counters["refused"] += not port.on_bus
            return port.on_bus
        port.send(self._obey(port, line))
        return False

    def _obey(self, port: _Port, line: bytes) -> bytes:
        command = line[:1]
        if line in (b"O", b"L", b"C"):
            port.on_bus = False
            port.forget()
            port.on_bus = line != b"C"
            return CR
        if line in ANSWERS:
            return ANSWERS[line]
        if not line or command in SETTINGS:
            return CR
        self.counters["garbage"] += 1
        return BELL
