"""What is a fault for a while: a counter that rises, and evidence of two nodes with one node id, which CAN itself does
not notice."""

from collections import Counter, deque

from ods.base.clock import NS

WINDOW_NS = 1_500_000_000
"""Longer than most heartbeat periods, and short enough that its end is reported within 2 s."""
NEVER_NS = -(1 << 62)
WHILE_NS = NS


class DuplicateNode:
    """Believed when `needed` pieces of evidence come within WINDOW_NS, and for that time after the last.

    Every piece counts as `counter`.
    """

    def __init__(self, counter: str, counters: Counter[str], needed: int) -> None:
        self._counter, self._counters = counter, counters
        self._times: deque[int] = deque([NEVER_NS] * needed, maxlen=needed)

    def seen(self, t_ns: int) -> None:
        """Record a frame that a single node cannot have sent."""
        self._counters[self._counter] += 1
        self._times.append(t_ns)

    def now(self, now_ns: int) -> bool:
        """Return whether two nodes send."""
        first_ns, last_ns = self._times[0], self._times[-1]
        return last_ns - first_ns <= WINDOW_NS and now_ns - last_ns <= WINDOW_NS


class RecentEvent:
    """Whether a counter has risen within the last second, as far as `now` was asked often enough to see."""

    def __init__(self, counter: str, counters: Counter[str]) -> None:
        self._counter, self._counters = counter, counters
        self._count = counters[counter]
        self._until_ns: int | None = None

    def now(self, now_ns: int) -> bool:
        """Return whether it has."""
        if self._counters[self._counter] != self._count:
            self._count, self._until_ns = self._counters[self._counter], now_ns + WHILE_NS
        return self._until_ns is not None and now_ns < self._until_ns
