"""Hypotheses for the common apparent motion of static objects, the likely one as text."""

import math
from collections.abc import Callable
from itertools import islice
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.tracker.common_error.least_squares import Fit, Reduced, fit
from ods.tracker.common_error.sightings import EAST, LATENCY, NORTH, SCALE, TURN, YAW

FEWEST = 3
"""Least number of objects; two may both be moving."""
OUTLIER_RATIO = 2.0
"""An object goes its own way, and is left out, if the others alone leave a mean square less by this ratio."""
SIGNIFICANT = 5.0
"""Standard deviations from which on an error is certain,"""
SURELY = 3.0
"""and by which it must be over its limit."""
MAX_RESIDUAL = 6.0
"""Mean square of what an explanation may leave, in units of what the echoes claim."""
STEPS = 3
"""Number of times that a large angle is fitted again: then it is within a percent."""
ALIKE = 0.9
"""An error that explains this share of what the best one does may be it as well;"""
NO_LESS = 0.98
"""one for which a list is not valid has to explain this share, or movers alike would do."""


class Cause(NamedTuple):
    """One kind of error."""

    judged: tuple[int, ...]
    """Columns of the design whose values give its size,"""
    beside: tuple[int, ...]
    """and those that have to be fitted beside them."""
    least: float
    """Smaller errors are normal for the devices."""
    limit: float
    """With a larger error the list is not valid."""
    most: float
    """A larger value cannot be this error."""
    words: Callable[[float, float], str]
    """Says it, by the value of the first column, or the size of several, and its standard error."""


class Finding(NamedTuple):
    """An error that explains how objects move."""

    cause: Cause
    fit: Fit

    @property
    def value(self) -> float:
        """Of the only column judged; of several, their length."""
        judged = self.fit.value[: len(self.cause.judged)]
        if self.cause.judged == (YAW,):
            return math.asin(max(-1.0, min(1.0, float(judged[0]))))
        return float(judged[0]) if len(judged) == 1 else float(np.linalg.norm(judged))

    def offset(self, design: Floats) -> Floats:
        """Return (k, 2) by how much places are off now, of a (k, 2, columns) design."""
        columns = (*self.cause.judged, *self.cause.beside)
        off = [
            value * design[:, :, column]
            for column, value in zip(columns, self.fit.value, strict=True)
            if column in OFFSETS
        ]
        return np.sum(off, axis=0) if off else np.zeros(design.shape[:2])

    @property
    def sigma(self) -> float:
        """Of it."""
        return float(np.linalg.norm(self.fit.sigma[: len(self.cause.judged)]))

    @property
    def is_of_convoy(self) -> bool:
        """A drift that explains as much would rather be a convoy on the vehicle's course."""
        return self.cause is WRONG_SCALE and abs(self.value) > CONVOY_SCALE

    def is_too_much(self, convoy: bool) -> bool:
        """Return whether the list is not valid with it; convoy: what moves alike may be one."""
        limit = NO_CONVOY if self.cause is DRIFT and not convoy else self.cause.limit
        return abs(self.value) - SURELY * self.sigma > limit

    def __str__(self) -> str:
        """Say it in plain words."""
        return self.cause.words(self.value, self.sigma)

    @property
    def holds(self) -> bool:
        """It is certain."""
        certain = self.cause.most > abs(self.value) > max(self.cause.least, SIGNIFICANT * self.sigma)
        return certain and self.fit.left < MAX_RESIDUAL

    @property
    def worth(self) -> float:
        """Explained sum of squares, less what each additional unknown explains by chance."""
        return self.fit.gain - SIGNIFICANT**2 * (len(self.fit.value) - 1)


def _turn(value: float, sigma: float) -> str:
    digits = 1 if abs(value) > math.radians(1.0) else 2
    rate = f"{math.degrees(value):.{digits}f} +- {math.degrees(sigma):.{digits}f} deg/s"
    asked = "does the heading drift, or are port and starboard exchanged?"
    return f"static objects seem to turn by {rate} about the vehicle: {asked}"


def _yaw(value: float, sigma: float) -> str:
    size = f"{math.degrees(abs(value)):.1f} +- {math.degrees(sigma):.1f} deg"
    return f"sonar.mounting.yaw_deg, or the heading, is {size} too {'large' if value > 0.0 else 'small'}"


def _scale(value: float, sigma: float) -> str:
    size = f"{100.0 * abs(value):.1f} +- {100.0 * sigma:.1f} %"
    return f"ranges are {size} too {'long' if value > 0.0 else 'short'}: is the sound speed right?"


def _latency(value: float, sigma: float) -> str:
    size = f"{1000.0 * abs(value):.0f} +- {1000.0 * sigma:.0f} ms"
    return f"poses are stamped {size} too {'early' if value > 0.0 else 'late'}, by the pings' clock"


def _drift(value: float, sigma: float) -> str:
    return f"static objects seem to move by {value:.2f} +- {sigma:.2f} m/s: does the INS's position drift?"


def _far_off(value: float, sigma: float) -> str:
    ratio = f"{value:.1f} +- {sigma:.1f} times"
    question = "is the heading wrong, or are ranges in another unit?"
    return f"static objects seem to move {ratio} as fast as the vehicle: {question}"


DRIFT = Cause((NORTH, EAST), (), 0.1, math.inf, math.inf, _drift)
"""Movers alike may be a convoy, or buoys in a current."""
NO_CONVOY = 0.5
"""The limit, m/s, where the poses themselves are doubtful."""
LARGE_ERROR = Cause((YAW, SCALE), (), 0.9, 1.0, math.inf, _far_off)
"""A heading and a scale of any size. Only a heading off by more than 60 degrees, or a range in another unit, makes what
is static faster than the vehicle."""
FASTEST_TURN = math.radians(0.5)
"""With a faster one places are off by more than they claim, within seconds. No movers turn about us."""
LARGEST_ANGLE = math.radians(60.0)
FAST_TURN = Cause((TURN,), (NORTH, EAST), math.radians(0.2), FASTEST_TURN, LARGEST_ANGLE, _turn)
"""By an angle of any size: the angle itself is as a drift."""
SLOW_TURN = Cause((TURN,), (YAW,), math.radians(0.05), FASTEST_TURN, FASTEST_TURN, _turn)
"""By a small angle, which itself is as an error of the yaw."""
WRONG_YAW = Cause((YAW,), (), math.radians(0.5), math.radians(5.0), LARGEST_ANGLE, _yaw)
"""A larger one is far off."""
WRONG_SCALE = Cause((SCALE,), (), 0.005, 0.05, LARGE_ERROR.least, _scale)
CONVOY_SCALE = 0.12
"""On one course a larger error of the ranges is as a convoy; one of a tenth is estimated to be less."""
LATE_POSES = Cause((LATENCY,), (), 0.02, 0.3, 0.6, _latency)
FAST = (FAST_TURN, DRIFT)
SLOW = (SLOW_TURN, DRIFT, LARGE_ERROR, WRONG_YAW, WRONG_SCALE, LATE_POSES)
OFFSETS = YAW, SCALE, LATENCY
"""Columns of errors by which a place is off now; of the others only their rates are known."""


def explanations(reduced: Reduced, causes: tuple[Cause, ...]) -> list[Finding]:
    """Return the errors that may be, best first; one object in three may go its own way."""
    if len(reduced.freedom) < FEWEST:
        return []
    found = [each for each in (estimate(reduced, cause) for cause in causes) if each is not None]
    certain = sorted((each for each in found if each.holds), key=lambda each: -each.worth)
    most = certain[0].fit.gain if certain else 0.0
    convoy = any(each.cause is DRIFT and each.fit.gain > most - SIGNIFICANT**2 for each in found)
    return [each for each in certain if each.fit.gain >= ALIKE * most and not (convoy and each.is_of_convoy)]


def too_much(found: list[Finding], convoy: bool) -> list[str]:
    """Return why a list is not valid for the errors that may be, best first; convoy: see `Finding.is_too_much`."""
    worst = (each for each in found if each.is_too_much(convoy) and each.fit.gain >= NO_LESS * found[0].fit.gain)
    return [str(each) for each in islice(worst, 1)]


def estimate(reduced: Reduced, cause: Cause) -> Finding | None:
    """Return how large an error is; of an angle, by places as the angle itself has moved them."""
    found = _fitted(reduced, cause)
    for _ in range(STEPS if cause.judged == (YAW,) else 0):
        if found is None or abs(found.value) > cause.most:
            break
        found = _fitted(reduced.turned(found.value), cause)
    return found


def _fitted(reduced: Reduced, cause: Cause) -> Finding | None:
    """Return how large an error is, without the objects that go their own way."""
    found = fit(reduced, cause.judged + cause.beside)
    for _ in range(len(reduced.freedom) // FEWEST):
        if found is None or len(reduced.freedom) <= FEWEST + 1:
            break
        best = int(found.left_without.argmin())
        if found.left < OUTLIER_RATIO * max(1.0, float(found.left_without[best])):
            break
        reduced = reduced.without(best)
        found = fit(reduced, cause.judged + cause.beside)
    return None if found is None else Finding(cause, found)
