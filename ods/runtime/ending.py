"""End of a process from outside: by signals, and by the end of its parent."""

import ctypes
import os
import signal
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
        for number in _SIGNALS:
            signal.signal(number, self._hear)

    def _hear(self, _number: int, _frame: Any) -> None:
        self.asked = True


def end_with(parent: int) -> bool:
    """Ask Linux for SIGTERM when the parent ends, so that no orphan remains; return whether the parent still exists."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    return os.getppid() == parent


def end_with_supervisor() -> None:
    """End with the process that is named in the environment, so that no orphan keeps a device or a lock.

    Raises OrphanError.
    """
    supervisor = os.environ.get(SUPERVISOR_PID)
    if supervisor is not None and not end_with(int(supervisor)):
        raise OrphanError("the supervisor died while this process started")
