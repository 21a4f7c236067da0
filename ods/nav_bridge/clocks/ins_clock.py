"""The INS's clock, mapped onto CLOCK_MONOTONIC."""

from collections import Counter

from ods.base.clock import DAY_MS, MS
from ods.base.clock_sync import OffsetEstimator


class InsClock:
    """Unwraps an INS's clock where it starts again from 0, and maps it: by default the time of day, ms.

    The date is not used: an INS without a fix may not know it. Counts `ins_clock_jumps` and `ins_clock_wild`, which are
    those of `OffsetEstimator`.
    """

    def __init__(
        self, jump_ns: int, counters: Counter[str], wraps_at: float | None = DAY_MS, tick_ns: float = MS
    ) -> None:
        """`wraps_at`: ticks, None for a clock that never wraps; `tick_ns`: length of one."""
        self.estimator = OffsetEstimator(jump_ns=jump_ns)
        self._counters = counters
        self._wraps_at, self._tick_ns = wraps_at, tick_ns
        self._last: float = 0
        self._unwrapped: float = 0

    @property
    def late_ns(self) -> int:
        """How long the line held the newest message back."""
        return self.estimator.held_back_ns

    def instant(self, ticks: float, arrival_ns: int) -> int:
        """Return the monotonic time, ns, of a reading of the clock in a message of `arrival_ns`."""
        step = ticks - self._last
        if self._wraps_at is not None:
            step = (step + self._wraps_at // 2) % self._wraps_at - self._wraps_at // 2
        self._last = ticks
        self._unwrapped += step
        instant_ns = self.estimator.map(round(self._unwrapped * self._tick_ns), arrival_ns)
        self._counters["ins_clock_jumps"], self._counters["ins_clock_wild"] = self.estimator.jumps, self.estimator.wild
        return instant_ns
