"""What the map's file is late with, and since when: said once, when it takes too long."""

import logging
from collections.abc import Callable

from ods.base.clock import NS

log = logging.getLogger(__name__)

READ, WRITTEN = "read", "written"
STALLED_NS = 3 * NS
"""A disk that takes longer is said to stall."""


class WriteDelay:
    """Since when something has been wanted of the file that is not done yet. All times are CLOCK_MONOTONIC ns."""

    def __init__(self, name: str, complain: Callable[[str, str], None]) -> None:
        """`complain` takes a counter's name and a line."""
        self.wanted = READ
        """What is wanted: that the file be READ, or WRITTEN."""
        self._name = name
        self._complain = complain
        self._since_ns: int | None = None
        self._failure = ""
        self._stalled = False
        self._overload = ""

    def begin(self, now_ns: int) -> None:
        """Something is wanted of the file from now on."""
        if self._since_ns is None:
            self._since_ns = now_ns

    def failed(self, reason: str) -> None:
        """Record a failure; `reason` is one line that names the file."""
        self._failure = reason

    def done(self, now_ns: int) -> None:
        """It is done."""
        if self._failure or self._stalled:
            log.warning("%s: %s again, after %.0f s", self._name, self.wanted, self._lasted_s(now_ns))
        self._since_ns, self._failure, self._stalled = None, "", False

    def look(self, now_ns: int, overload: str) -> None:
        """Log once when it takes too long. overload: text that the computer is overloaded, or ""."""
        self._overload = overload
        if not self._failure and not self._stalled and self._lasted_s(now_ns) * NS > STALLED_NS:
            self._stalled = True
            self._complain("map_stalled", self.problem(now_ns))

    def problem(self, now_ns: int) -> str:
        """Return what is wrong; empty when nothing is."""
        if not self._failure and not self._stalled:
            return ""
        silent = (
            "the disk does not answer"
            if self.wanted == WRITTEN
            else "its process has not started yet, or the disk does not respond"
        )
        cause = self._failure or f"{self._name}: {self._overload or silent}"
        return f"{cause}; not {self.wanted} for {self._lasted_s(now_ns):.0f} s"

    def _lasted_s(self, now_ns: int) -> float:
        return 0.0 if self._since_ns is None else (now_ns - self._since_ns) / NS
