"""Which altitudes over the bottom are believed. A pose is as good without one, so a wrong one is only left out."""

import logging
from collections import Counter
from typing import NamedTuple

from ods.base.clock import NS

log = logging.getLogger(__name__)

STILL_S, STILL_M = 2.0, 2.0
"""An altitude that has been the same, to the last digit, for so long, while the vehicle's depth changed by so much, is
not measured any more: an altimeter hangs, or tells its longest range as it hears no bottom."""


class ToldAltitude(NamedTuple):
    """An altitude as it came, m, and where and when it was told."""

    told_m: float
    t_ns: int
    down_m: float
    """Of the vehicle."""


class AltitudeSense:
    """Counts `altitude_absurd` and `altitude_still`, and says the first of each."""

    def __init__(self, highest_m: float, counters: Counter[str]) -> None:
        self._highest_m = highest_m
        self._counters = counters
        self._first: ToldAltitude | None = None
        """Since it has been the same;"""
        self._downs = 0.0, 0.0
        """and the least and the greatest depth since."""

    def believes(self, altitude_m: float, sigma_m: float, told: ToldAltitude) -> bool:
        """Return whether an altitude and its standard deviation, made of what was told, can be the vehicle's."""
        hangs = self._hangs(told)
        if not (0.0 < altitude_m <= self._highest_m and 0.0 <= sigma_m <= self._highest_m):  # written so that NaN fails
            limit = f"it must be above 0, and nav.limits.altitude_m is {self._highest_m:g}"
            self._doubt("altitude_absurd", f"{altitude_m:.6g} m, to {sigma_m:.3g} m: {limit}")
            return False
        if hangs:
            told_as = f"{told.told_m:.6g} m all the time, though the depth changed by {self._rise_m:.1f} m"
            self._doubt("altitude_still", told_as)
            return False
        return True

    def _hangs(self, told: ToldAltitude) -> bool:
        if self._first is None or told.told_m != self._first.told_m:
            self._first, self._downs = told, (told.down_m, told.down_m)
        self._downs = min(self._downs[0], told.down_m), max(self._downs[1], told.down_m)
        return told.t_ns - self._first.t_ns > STILL_S * NS and self._rise_m > STILL_M

    @property
    def _rise_m(self) -> float:
        return self._downs[1] - self._downs[0]

    def _doubt(self, counter: str, why: str) -> None:
        if not self._counters[counter]:
            log.warning("the altitude over the bottom is left out of poses: %s (said once, then counted as %s)",
                        why, counter)  # fmt: skip
        self._counters[counter] += 1
