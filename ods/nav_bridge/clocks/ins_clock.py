"""The INS's clock, mapped onto CLOCK_MONOTONIC."""

from ods.base.clock import DAY_MS, MS
from ods.base.clock_sync import OffsetEstimator

MASK_28_BIT = (1 << 28) - 1
"""TIME_OF_DAY has four reserved bits above its milliseconds (CiA 301)."""
DAYS_1970_TO_1984 = 5113
"""TIME_OF_DAY counts days from 1984-01-01."""


def day_ms(raw: float) -> int | None:
    """Return the milliseconds since midnight of a raw TIME_OF_DAY count, None when no day is that long."""
    milliseconds = int(raw) & MASK_28_BIT
    return milliseconds if milliseconds < DAY_MS else None


def utc_of_time_of_day(milliseconds: int, days: int) -> int:
    """Return ns since 1970 of a TIME_OF_DAY."""
    return ((days + DAYS_1970_TO_1984) * DAY_MS + milliseconds) * MS


class InsClock:
    """Unwraps an INS's clock where it starts again from 0, and maps it: by default the time of day, ms.

    The date is not used: an INS without a fix may not know it.
    """

    def __init__(self, jump_ns: int, wraps_at: float | None = DAY_MS, tick_ns: float = MS) -> None:
        """`wraps_at`: ticks, None for a clock that never wraps; `tick_ns`: length of one."""
        self.estimator = OffsetEstimator(jump_ns=jump_ns)
        self._wraps_at, self._tick_ns = wraps_at, tick_ns
        self._last: float = 0
        self._unwrapped: float = 0

    @property
    def late_ns(self) -> int:
        """How long the line held the newest message back."""
        return self.estimator.held_back_ns

    def instant(self, ticks: float, arrival_ns: int) -> int:
        """Return the monotonic time, ns, of a reading of the clock, told by a message of `arrival_ns`."""
        step = ticks - self._last
        if self._wraps_at is not None:
            step = (step + self._wraps_at // 2) % self._wraps_at - self._wraps_at // 2
        self._last = ticks
        self._unwrapped += step
        return self.estimator.map(round(self._unwrapped * self._tick_ns), arrival_ns)
