"""Events that are a fault for a while, detected by a counter."""

from collections import Counter

from ods.base.clock import NS

WHILE_NS = NS


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
