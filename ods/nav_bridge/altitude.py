"""Plausibility of altitudes over the bottom. A pose does not need one, so a wrong one is only omitted."""

import logging
from collections import Counter
from typing import NamedTuple

from ods.base.clock import NS

log = logging.getLogger(__name__)

STILL_S, STILL_M = 2.0, 2.0
"""An altitude that has been the same, to the last digit, for this time, s, while the vehicle's depth changed by this
distance, m, is not measured any more: an altimeter hangs, or reports its longest range as it receives no echo."""


class ReportedAltitude(NamedTuple):
    """An altitude as received, m, and depth and time of its report."""

    altitude_m: float
    t_ns: int
    down_m: float
    """Of the vehicle."""


class AltitudeCheck:
    """Counts `altitude_absurd` and `altitude_still`, and logs the first of each."""

    def __init__(self, highest_m: float, counters: Counter[str]) -> None:
        self._highest_m = highest_m
        self._counters = counters
        self._first: ReportedAltitude | None = None
        """First report of the present value."""
        self._downs = 0.0, 0.0
        """Least and greatest depth, m, since then."""

    def is_plausible(self, altitude_m: float, sigma_m: float, reported: ReportedAltitude) -> bool:
        """Return whether an altitude and its standard deviation, derived from `reported`, can be the vehicle's."""
        hangs = self._hangs(reported)
        if not (0.0 < altitude_m <= self._highest_m and 0.0 <= sigma_m <= self._highest_m):  # written so that NaN fails
            limit = f"it must be above 0, and nav.limits.altitude_m is {self._highest_m:g}"
            self._reject("altitude_absurd", f"{altitude_m:.6g} m, to {sigma_m:.3g} m: {limit}")
            return False
        if hangs:
            unchanged = f"{reported.altitude_m:.6g} m constantly, although the depth changed by {self._rise_m:.1f} m"
            self._reject("altitude_still", unchanged)
            return False
        return True

    def _hangs(self, reported: ReportedAltitude) -> bool:
        if self._first is None or reported.altitude_m != self._first.altitude_m:
            self._first, self._downs = reported, (reported.down_m, reported.down_m)
        self._downs = min(self._downs[0], reported.down_m), max(self._downs[1], reported.down_m)
        return reported.t_ns - self._first.t_ns > STILL_S * NS and self._rise_m > STILL_M

    @property
    def _rise_m(self) -> float:
        return self._downs[1] - self._downs[0]

    def _reject(self, counter: str, why: str) -> None:
        if not self._counters[counter]:
            log.warning("poses have no altitude over the bottom: %s (logged once, then counted as %s)",
                        why, counter)  # fmt: skip
        self._counters[counter] += 1
