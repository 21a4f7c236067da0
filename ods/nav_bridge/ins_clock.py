"""The INS's time of day, mapped onto CLOCK_MONOTONIC."""

from ods.clock import OffsetEstimator

MS = 1_000_000
DAY_MS = 86_400_000
MASK_28_BIT = (1 << 28) - 1
"""TIME_OF_DAY has four reserved bits above its milliseconds (CiA 301)."""
DAYS_1970_TO_1984 = 5113
"""TIME_OF_DAY counts days from 1984-01-01."""


def day_ms(raw: float) -> int | None:
    """Return the milliseconds since midnight of a raw TIME_OF_DAY count, None when no day is that long."""
    milliseconds = int(raw) & MASK_28_BIT
    return milliseconds if milliseconds < DAY_MS else None


def utc_ns(milliseconds: int, days: int) -> int:
    """Return ns since 1970 of a TIME_OF_DAY."""
    return ((days + DAYS_1970_TO_1984) * DAY_MS + milliseconds) * MS


class InsClock:
    """Unwraps the time of day at midnight and maps it. The date is not used: an INS without a fix may not know it."""

    def __init__(self, jump_ns: int) -> None:
        self.estimator = OffsetEstimator(jump_ns=jump_ns)
        self._last_ms = 0
        self._unwrapped_ms = 0

    def instant(self, milliseconds: int, arrival_ns: int) -> int:
        """Return the monotonic time, ns, of `milliseconds` since midnight, told by a message of `arrival_ns`."""
        step = (milliseconds - self._last_ms + DAY_MS // 2) % DAY_MS - DAY_MS // 2
        self._last_ms = milliseconds
        self._unwrapped_ms += step
        return self.estimator.map(self._unwrapped_ms * MS, arrival_ns)
