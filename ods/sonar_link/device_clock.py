"""A sonar's own clock, mapped onto this machine's."""

from collections import Counter

from ods.base.clock import NS
from ods.base.clock_sync import OffsetEstimator

LATE_NS = NS // 2


class DeviceClock:
    """One device's clock. Counters: device_clock_jumps, wild_device_times, pings_held_back."""

    def __init__(self, counters: "Counter[str]") -> None:
        self._estimator = OffsetEstimator()
        self._counters = counters

    def local_ns(self, device_ns: int, arrival_ns: int) -> int:
        """Return the CLOCK_MONOTONIC time of `device_ns`, sent in a message that came at `arrival_ns`, ns."""
        jumps, wild = self._estimator.jumps, self._estimator.wild
        t_ns = self._estimator.map(device_ns, arrival_ns)
        self._counters["device_clock_jumps"] += self._estimator.jumps - jumps
        self._counters["wild_device_times"] += self._estimator.wild - wild
        self._counters["pings_held_back"] += self._estimator.held_back_ns > LATE_NS
        return t_ns
