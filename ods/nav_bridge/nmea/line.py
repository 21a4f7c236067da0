"""Splits received bytes into lines."""

from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

LONGEST = 255
"""Bytes of a line. NMEA 0183 allows 82, makers' own sentences are somewhat longer."""


class Line(NamedTuple):
    """One line without its end."""

    data: bytes
    t_ns: int
    """When its first byte arrived, CLOCK_MONOTONIC."""


class LineSplitter:
    """Finds the lines, and keeps less than one. Counts `line_overlong`: those longer than LONGEST, dropped."""

    def __init__(self, counters: Counter[str]) -> None:
        self._counters = counters
        self._rest = b""
        self._begun_ns = 0
        self._skipping = False

    def feed(self, data: bytes, t_ns: int) -> Iterator[Line]:
        """Take bytes that arrived at `t_ns`; yield the lines that they end."""
        *ended, rest = data.replace(b"\r", b"\n").split(b"\n")
        for part in ended:
            line = self._rest + part
            begun_ns = self._begun_ns if self._rest else t_ns
            self._rest = b""
            if self._skipping or len(line) > LONGEST:
                self._counters["line_overlong"] += 1
                self._skipping = False
            elif line:
                yield Line(line, begun_ns)
        if rest and not self._rest:
            self._begun_ns = t_ns
        self._rest += rest
        if self._skipping or len(self._rest) > LONGEST:
            self._rest, self._skipping = b"", True

    @property
    def endless(self) -> bool:
        """Return whether the line under way is too long already."""
        return self._skipping

    def forget(self) -> None:
        """Forget the unfinished line: the connection was opened again."""
        self._rest, self._skipping = b"", False
