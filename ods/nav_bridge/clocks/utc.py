"""Which UTC poses are stamped with: this computer's clock, or the INS's. Pure: the caller reads the clock.

Nothing but stamps depends on it: the chain itself goes by CLOCK_MONOTONIC.

    this computer's clock   the INS's time     UTC is        told as
    synchronized            none, or the same  the clock's   clock
    synchronized            valid, > 1 s off   the clock's   unsure
    not synchronized        valid              the INS's     ins
    not synchronized        none, not valid    the clock's   unsure
"""

import logging
from collections.abc import Callable
from typing import NamedTuple

from ods.base.clock import NS
from ods.messages import UtcSource

log = logging.getLogger(__name__)

AGREEMENT_NS = NS
"""Two clocks that differ by less are taken for the same."""


class WallClock(NamedTuple):
    """This computer's clock."""

    ahead_ns: int
    """Of CLOCK_MONOTONIC."""
    synchronized: bool
    """By NTP, PTP or the like, as the kernel knows it."""


class Utc:
    """UTC of any instant of CLOCK_MONOTONIC."""

    def __init__(self, wall_clock: Callable[[], WallClock]) -> None:
        self._wall_clock = wall_clock
        self._ins_ahead_ns: int | None = None
        self._said: set[str] = set()

    def tell(self, ins_ahead_ns: int | None) -> None:
        """Take how far the INS's UTC is ahead of CLOCK_MONOTONIC; None: it tells none, or none that is valid."""
        self._ins_ahead_ns = ins_ahead_ns

    def at(self, t_ns: int) -> tuple[int, UtcSource]:
        """Return UTC of an instant, ns, and whose it is."""
        wall, ins_ns = self._wall_clock(), self._ins_ahead_ns
        if not wall.synchronized and ins_ns is not None:
            return t_ns + ins_ns, self._told("ins", f"{_difference(ins_ns, wall)}, which is not synchronized")
        if not wall.synchronized:
            why = "this computer's clock is not synchronized, and the INS tells no valid UTC"
            return t_ns + wall.ahead_ns, self._told("unsure", why)
        if ins_ns is not None and abs(ins_ns - wall.ahead_ns) > AGREEMENT_NS:
            return t_ns + wall.ahead_ns, self._told("unsure", f"{_difference(ins_ns, wall)}, which is synchronized")
        return t_ns + wall.ahead_ns, self._told("clock", "this computer's clock is synchronized")

    def _told(self, source: UtcSource, why: str) -> UtcSource:
        """Log what is told of UTC; that all is well is news only after something else."""
        if source not in self._said and (source != "clock" or self._said):
            self._said.add(source)
            log.warning("UTC of poses and lists is now %r: %s (said once)", source, why)
        return source


def _difference(ins_ns: int, wall: WallClock) -> str:
    return f"the INS's is {(ins_ns - wall.ahead_ns) / NS:+.1f} s from this computer's clock"
