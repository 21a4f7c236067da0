"""How often a device sends: the usual step between its instants."""

from collections import deque
from statistics import median

STEPS = 9
"""That are remembered: a busy computer, or device, makes single ones shorter and longer."""


class Period:
    """The median of the newest steps between complete epochs."""

    def __init__(self) -> None:
        self._last_ns: int | None = None
        self._steps_ns: deque[int] = deque(maxlen=STEPS)

    def add(self, instant_ns: int) -> int:
        """Take the instant of a complete epoch, CLOCK_MONOTONIC; return the step to it, ns, 0 for the first."""
        last_ns, self._last_ns = self._last_ns, instant_ns
        if last_ns is None:
            return 0
        self._steps_ns.append(instant_ns - last_ns)
        return instant_ns - last_ns

    @property
    def ns(self) -> int:
        """The period, ns, 0 while it is not known."""
        return round(median(self._steps_ns)) if self._steps_ns else 0
