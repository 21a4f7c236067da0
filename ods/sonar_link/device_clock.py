"""A sonar's own clock, mapped onto this machine's."""

from collections import Counter

from ods.base.clock_sync import OffsetEstimator


class DeviceClock:
    """One device's clock. Counters: device_clock_jumps, wild_device_times."""

    def __init__(self, counters: "Counter[str]") -> None:
        self._estimator = OffsetEstimator()
        self._counters = counters

    def local_ns(self, device_ns: int, arrival_ns: int) -> int:
        """Return the CLOCK_MONOTONIC time of `device_ns`, which a message that came at `arrival_ns` tells, ns."""
        jumps, wild = self._estimator.jumps, self._estimator.wild
        t_ns = self._estimator.map(device_ns, arrival_ns)
        self._counters["device_clock_jumps"] += self._estimator.jumps - jumps
        self._counters["wild_device_times"] += self._estimator.wild - wild
        return t_ns
