"""The source of UTC for poses: this computer's clock, or the INS's. Pure: the caller reads the clock.

Nothing but stamps depends on it: the chain itself goes by CLOCK_MONOTONIC.

    this computer's clock   the INS's time     UTC is        source
    synchronized            none, or the same  the clock's   clock
    synchronized            valid, > 1 s off   the clock's   unsure
    not synchronized        valid              the INS's     ins
    not synchronized        none, not valid    the clock's   unsure
"""

import logging
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

from ods.base.clock import NS
from ods.base.clock_sync import OffsetEstimator
from ods.messages import UtcSource

log = logging.getLogger(__name__)

AGREEMENT_NS = NS
"""Largest difference of clocks that count as the same, ns."""
LATE_NS = NS // 2
EARLIEST_NS, LATEST_NS = 1_577_836_800 * NS, 4_102_444_800 * NS
"""UTC from 2020 until 2100: before lie GPS weeks that rolled over, clocks without a fix, and two-digit years; no
message carries a time after 2116."""
WINDOW = 16
"""Number of messages from which the offset is taken."""


class WallClock(NamedTuple):
    """This computer's clock."""

    ahead_ns: int
    """Of CLOCK_MONOTONIC."""
    synchronized: bool
    """By NTP, PTP or the like, by the kernel's flag."""


class ReportedUtc:
    """UTC as the navigation system or its network reports it; the instants of poses do not depend on it.

    Counts `time`, `time_bad` (of a year that cannot be), `time_wild` (late, or else off by more than half a second)
    and `time_jumps` (four such in a row that agree).
    """

    def __init__(self, counters: Counter[str]) -> None:
        self._counters = counters
        self._offset = OffsetEstimator(WINDOW, LATE_NS)
        self._newest: tuple[int, int] | None = None

    def take(self, utc_ns: int, arrival_ns: int) -> None:
        """Take UTC, ns since 1970, of a message of `arrival_ns`."""
        if not EARLIEST_NS <= utc_ns < LATEST_NS:
            self._counters["time_bad"] += 1
            return
        wild, jumps = self._offset.wild, self._offset.jumps
        t_ns = self._offset.map(utc_ns, arrival_ns)
        if self._offset.wild == wild or self._offset.jumps > jumps:  # one message off is a late one, not a new time
            self._newest = t_ns, utc_ns
        self._counters["time"] += 1
        self._counters["time_wild"], self._counters["time_jumps"] = self._offset.wild, self._offset.jumps

    @property
    def ahead_ns(self) -> int | None:
        """How far the reported UTC is ahead of CLOCK_MONOTONIC, ns; None before the first report."""
        return None if self._newest is None else self._newest[1] - self._newest[0]


class Utc:
    """UTC of any instant of CLOCK_MONOTONIC."""

    def __init__(self, wall_clock: Callable[[], WallClock]) -> None:
        self._wall_clock = wall_clock
        self._ins_ahead_ns: int | None = None
        self._said: set[str] = set()

    def take(self, ins_ahead_ns: int | None) -> None:
        """Take how far the INS's UTC is ahead of CLOCK_MONOTONIC; None: it sends none, or none that is valid."""
        self._ins_ahead_ns = ins_ahead_ns

    def at(self, t_ns: int) -> tuple[int, UtcSource]:
        """Return UTC of an instant, ns, and whose it is."""
        wall, ins_ns = self._wall_clock(), self._ins_ahead_ns
        if not wall.synchronized and ins_ns is not None:
            return t_ns + ins_ns, self._logged("ins", f"{_difference(ins_ns, wall)}, which is not synchronized")
        if not wall.synchronized:
            why = "this computer's clock is not synchronized, and the INS sends no valid UTC"
            return t_ns + wall.ahead_ns, self._logged("unsure", why)
        if ins_ns is not None and abs(ins_ns - wall.ahead_ns) > AGREEMENT_NS:
            return t_ns + wall.ahead_ns, self._logged("unsure", f"{_difference(ins_ns, wall)}, which is synchronized")
        return t_ns + wall.ahead_ns, self._logged("clock", "this computer's clock is synchronized")

    def _logged(self, source: UtcSource, why: str) -> UtcSource:
        """Log a change of the source and return it; `clock` is logged only after another one."""
        if source not in self._said and (source != "clock" or self._said):
            self._said.add(source)
            log.warning("UTC of poses and lists now has the source %r: %s (logged once)", source, why)
        return source


def _difference(ins_ns: int, wall: WallClock) -> str:
    return f"the INS's is {(ins_ns - wall.ahead_ns) / NS:+.1f} s from this computer's clock"
