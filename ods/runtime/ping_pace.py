"""Time without a ping after which the sonar counts as silent: with a long range it pings seldom."""

from collections import deque
from statistics import median_low

from ods.base.clock import NS
from ods.runtime import bus

SHORTEST_S = bus.TOPICS["ping"].stale_s
PERIODS = 3.0
"""A ping has come back a period after its transmission at the latest, the next one a period later; the third is for the
work on it, and what is late."""
LONGEST_S = 3.0
"""By then objects may be elsewhere, however seldom the sonar pings: a planner has to know."""
GAPS = 3
"""Number of intervals whose median is the sonar's pace, so that a single gap does not count."""


class PingPace:
    """Takes the times of pings as they come."""

    def __init__(self) -> None:
        self._newest_ns: int | None = None
        self._gaps_ns: deque[int] = deque(maxlen=GAPS)

    def ping(self, t_ns: int) -> None:
        """Record a ping; older ones are ignored."""
        newest_ns = self._newest_ns
        if newest_ns is not None and t_ns <= newest_ns:
            return
        if newest_ns is not None:
            self._gaps_ns.append(t_ns - newest_ns)
        self._newest_ns = t_ns

    @property
    def patience_s(self) -> float:
        """Return the duration of silence that is not yet a problem, s."""
        usual_s = median_low(self._gaps_ns) / NS if self._gaps_ns else 0.0
        return min(max(PERIODS * usual_s, SHORTEST_S), LONGEST_S)
