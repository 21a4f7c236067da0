"""How a process is ended from outside: by signals, and by the end of who started it."""

import ctypes
import os
import signal
import threading
from typing import Any

from ods.base.errors import OdsError

SUPERVISOR_PID = "ODS_SUPERVISOR_PID"
"""Environment variable of a process that must not outlive who started it."""
_SIGNALS = signal.SIGTERM, signal.SIGINT
_PR_SET_PDEATHSIG = 1


class OrphanError(OdsError):
    """Who started this process has gone already."""


class Stop:
    """Hears SIGTERM and SIGINT, so that a work loop can come to its end."""

    def __init__(self) -> None:
        self.asked = False
        self.listen()

    def listen(self) -> None:
        """Hear them from now on, also after `end_at_once`."""
        if signal.getsignal(signal.SIGTERM) != self._hear:
            for number in _SIGNALS:
                signal.signal(number, self._hear)

    def _hear(self, _number: int, _frame: Any) -> None:
        self.asked = True


def end_at_once() -> None:
    """Let SIGTERM and SIGINT end the process by themselves: a compiler is deaf for minutes, and nothing is at stake."""
    if threading.current_thread() is not threading.main_thread():  # only that one may
        return
    listener = getattr(signal.getsignal(signal.SIGTERM), "__self__", None)
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    if isinstance(listener, Stop) and listener.asked:
        signal.raise_signal(signal.SIGTERM)


def end_with(parent: int) -> bool:
    """Ask Linux for SIGTERM when the parent ends, so that no orphan goes on; tell whether it is there still."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    return os.getppid() == parent


def end_with_supervisor() -> None:
    """End with the process that is named in the environment, so that no orphan keeps a device or a lock.

    Raises OrphanError.
    """
    supervisor = os.environ.get(SUPERVISOR_PID)
    if supervisor is not None and not end_with(int(supervisor)):
        raise OrphanError("the supervisor died while this process started")
