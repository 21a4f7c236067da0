"""Steps of this machine's wall clock, which poses survive but a reader of the log should know of."""

from collections import Counter

STEP_NS = 100_000_000
"""NTP slews by less than this between two looks; a step is larger."""


class WallClock:
    """Counts `wall_clock_steps`."""

    def __init__(self, counters: Counter[str]) -> None:
        self._counters = counters
        self._offset_ns: int | None = None

    def watch(self, t_ns: int, utc_ns: int) -> None:
        """Compare both clocks' readings of one instant with the last ones."""
        offset_ns = utc_ns - t_ns
        if self._offset_ns is not None and abs(offset_ns - self._offset_ns) > STEP_NS:
            self._counters["wall_clock_steps"] += 1
        self._offset_ns = offset_ns
