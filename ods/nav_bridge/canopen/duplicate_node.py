"""Evidence that two nodes send with one node id, which CAN itself does not notice."""

from collections import Counter, deque

WINDOW_NS = 1_500_000_000
"""Longer than most heartbeat periods, and short enough that its end is reported within 2 s."""


NEVER_NS = -(1 << 62)


class DuplicateNode:
    """Believed when `needed` pieces of evidence come within WINDOW_NS, and for that time after the last.

    Every piece counts as `counter`.
    """

    def __init__(self, counter: str, counters: Counter[str], needed: int) -> None:
        self._counter, self._counters = counter, counters
        self._times: deque[int] = deque([NEVER_NS] * needed, maxlen=needed)

    def seen(self, t_ns: int) -> None:
        """Take note of a frame that one node alone cannot have sent."""
        self._counters[self._counter] += 1
        self._times.append(t_ns)

    def now(self, now_ns: int) -> bool:
        """Return whether two nodes send."""
        first_ns, last_ns = self._times[0], self._times[-1]
        return last_ns - first_ns <= WINDOW_NS and now_ns - last_ns <= WINDOW_NS
