"""A port that may vanish and come back: non-blocking reads and writes, and reopening as a small state machine.

Closed -> (pause over) -> opening -> open -> (error, end of file, device gone, silence) -> closed. The pause doubles
with every failure, up to a limit, until data have come. No clock and no thread: the caller passes the time and polls
`fd`.
"""

import errno
import logging
import termios
from abc import ABC, abstractmethod
from collections import Counter
from enum import Enum

from ods.base.clock import NS
from ods.base.errors import reason_of
from ods.runtime.port.backoff import Backoff

log = logging.getLogger(__name__)

PORT_READ_BYTES = 65536
ERRORS = (OSError, ValueError, termios.error)


class PortError(OSError):
    """The port cannot be used; its text says why in plain words."""


class _State(Enum):
    CLOSED = 1
    OPENING = 2
    OPEN = 3


class Port(ABC):
    """The state machine; what is opened is a subclass's. Counters: port_opens, port_losses, port_open_errors."""

    def __init__(self, name: str, pauses_s: tuple[float, float], counters: "Counter[str] | None" = None) -> None:
        """Make a closed port; pauses_s: shortest and longest pause before it is tried again."""
        self.counters: Counter[str] = Counter() if counters is None else counters
        self.fault = f"{name}: not opened yet"
        """Why the port is not open, in plain words; '' when it is."""
        self._logged = ""
        """The fault that was logged last, until data have come."""
        self._name = name
        self._backoff = Backoff(*pauses_s)
        self._due_ns = 0
        self._state = _State.CLOSED
        self._received_ns = 0

    @property
    def fd(self) -> int | None:
        """The descriptor to poll, None when not open."""
        return self._descriptor() if self._state is _State.OPEN else None

    def open_if_due(self, now_ns: int) -> bool:
        """Go on opening a port whose pause is over; return whether it is open now and was not before."""
        if self._state is _State.OPEN or (self._state is _State.CLOSED and now_ns < self._due_ns):
            return False
        try:
            if self._state is _State.CLOSED:
                self._state = _State.OPENING
                self._begin_opening(now_ns)
            if not self._finish_opening(now_ns):
                return False
        except ERRORS as error:
            self.counters["port_open_errors"] += 1
            self._close_and_wait(now_ns, error)
            return False
        self._state = _State.OPEN
        self._received_ns = now_ns
        self.counters["port_opens"] += 1
        self.fault = ""
        return True

    def read(self, now_ns: int) -> bytes:
        """Return what has come, PORT_READ_BYTES at most; b'' when nothing has, or the port was lost (`fd` is None)."""
        if self._state is not _State.OPEN:
            return b""
        try:
            data = self._receive()
        except ERRORS as error:
            self._lose(now_ns, error)
            return b""
        if data:
            self._received_ns = now_ns
            self._backoff.worked()
            if self._logged:
                self._logged = ""
                log.info("%s: data arrive again", self._name)
        return data

    def write(self, data: bytes, now_ns: int) -> bool:
        """Send `data` without waiting; return whether all of it went out. What did not is gone."""
        if self._state is not _State.OPEN:
            return False
        try:
            return self._send(data) == len(data)
        except BlockingIOError:
            return False
        except ERRORS as error:
            self._lose(now_ns, error)
            return False

    def check(self, now_ns: int) -> None:
        """Give an open port up if there is reason to, though no read has failed."""
        if self._state is _State.OPEN:
            try:
                self._examine(now_ns)
            except ERRORS as error:
                self._lose(now_ns, error)

    def close(self) -> None:
        """Give the port back."""
        self._state = _State.CLOSED
        self._release()

    @abstractmethod
    def _descriptor(self) -> int:
        """Return the descriptor of the open port."""

    @abstractmethod
    def _begin_opening(self, now_ns: int) -> None:
        """Start to open; never wait. Raises one of ERRORS, as all below may."""

    def _finish_opening(self, _now_ns: int) -> bool:
        """Return whether it is open now."""
        return True

    @abstractmethod
    def _receive(self) -> bytes:
        """Return what has come, b'' when nothing has; never wait."""

    @abstractmethod
    def _send(self, data: bytes) -> int:
        """Send what can be sent without waiting; return how many bytes that was."""

    @abstractmethod
    def _examine(self, now_ns: int) -> None:
        """Raise when the port is not what it was."""

    @abstractmethod
    def _release(self) -> None:
        """Release all resources, open or not."""

    def _lose(self, now_ns: int, error: Exception) -> None:
        self.counters["port_losses"] += 1
        self._close_and_wait(now_ns, error)

    def _close_and_wait(self, now_ns: int, error: Exception) -> None:
        self.close()
        locked = isinstance(error, OSError) and error.errno == errno.EAGAIN
        self.fault = f"{self._name}: {'in use by another program' if locked else reason_of(error)}"
        self._due_ns = now_ns + round(self._backoff.failed() * NS)
        if self.fault != self._logged:
            self._logged = self.fault
            log.warning("%s; trying again", self.fault)
