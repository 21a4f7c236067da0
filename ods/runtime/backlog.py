"""Messages that wait to be processed: all while the process keeps up, otherwise only the newest. Pure: no clock."""

from collections import deque
from typing import Generic, TypeVar

MessageT = TypeVar("MessageT")

SMOOTHING = 0.1
"""Weight of the newest in the running means."""


class Backlog(Generic[MessageT]):
    """What came and was not worked off yet, in order.

    A short burst is worked off as a whole. If that took longer than it takes the next message to come, what waits would
    grow, or stay: then only the newest is worth the work, which so begins after one message's work at the latest.
    """

    def __init__(self) -> None:
        self.work_ns = 0.0
        """Running mean of the work on one message; 0 before the first."""
        self.interval_ns = 0.0
        """Running mean of the time between two messages; 0 before the second."""
        self._waiting: deque[MessageT] = deque()
        self._last: tuple[int, int] | None = None

    def add(self, message: MessageT, seq: int, t_ns: int) -> None:
        """Let a message wait; number and time, ns, show how fast messages arrive."""
        self._waiting.append(message)
        if self._last is not None:
            numbers, span_ns = seq - self._last[0], t_ns - self._last[1]
            if numbers > 0 and span_ns > 0:
                self.interval_ns = _follow(self.interval_ns, span_ns / numbers)
        self._last = seq, t_ns

    def take(self) -> tuple[list[MessageT], int]:
        """Return the messages to be worked off now, in order, and how many were left out for them."""
        found = list(self._waiting)
        self._waiting.clear()
        keeps_up = 0.0 < len(found) * self.work_ns <= self.interval_ns
        worth = found if keeps_up else found[-1:]
        return worth, len(found) - len(worth)

    def worked(self, spent_ns: int) -> None:
        """Record the processing time of a message, ns."""
        self.work_ns = _follow(self.work_ns, spent_ns)

    def slowness(self) -> str:
        """Return the time of work and the period of messages, as text."""
        if not self.work_ns:
            return "pings came while it started"
        return f"a ping takes {self.work_ns / 1e6:.1f} ms to process, they come every {self.interval_ns / 1e6:.1f} ms"


def _follow(mean: float, newest: float) -> float:
    return mean + SMOOTHING * (newest - mean) if mean else newest
