"""Does an object exist? A chain of three hidden states an object, fed with hits and misses.

Rows of the (3, n) probabilities: VISIBLE (exists and gives echoes), SILENT (exists, gives none from here just now) and
NOTHING (a false track, or the object is gone). Missing an object in some images is normal [SSIE]: the silent state
keeps a well-established object alive through a silence that would end a young one.
"""

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.tracker.settings import EchoSettings

VISIBLE, SILENT, NOTHING = 0, 1, 2
YOUNG = 300.0
"""An object seen once is lost so many times sooner than an old one; the excess falls with the number of echoes."""
SMALLEST = 1e-300
MOST_EVIDENCE = 30.0
"""Largest log-likelihood ratio of one echo; e^30 leaves nothing of any doubt."""


def start(count: int, births: float, clutter: float) -> Array:
    """Return (3, count) probabilities of objects with one echo, given births and false alarms a scan."""
    column = np.array([births, 0.0, clutter]) / (births + clutter)
    return np.repeat(column[:, None], count, axis=1)


def established(existence: Array) -> Array:
    """Return (3, n) probabilities of objects taken from the map with (n,) `existence`."""
    return np.array([existence, np.zeros_like(existence), 1.0 - existence])


def carry_on(probabilities: Array, echoes: NDArray[np.int64], watched: Array, dt: float, echo: EchoSettings) -> Array:
    """Return (3, n) probabilities `dt` seconds later.

    `watched`: (n,) share of the time that the object was in the sonar's view: only there does it fall silent or come
    back. `echoes`: (n,) so far; a young object is more often an error of association, and in view is lost sooner.
    """
    visible, silent, nothing = probabilities
    time = dt * watched
    falls_silent = visible * -np.expm1(-echo.silence_rate * time)
    returns = silent * -np.expm1(-echo.return_rate * time)
    lost = -np.expm1(-echo.loss_rate * (dt + time * YOUNG / echoes))
    moved = returns - falls_silent
    stay = 1.0 - lost
    return np.array([stay * (visible + moved), stay * (silent - moved), nothing + lost * (visible + silent)])


def visibility(probabilities: Array, dt: float, echo: EchoSettings) -> Array:
    """Return (n,) the probability that an object, if it exists, gives echoes `dt` seconds later."""
    visible, silent, _ = probabilities
    exists = np.maximum(visible + silent, SMALLEST)
    return np.asarray((visible + silent * -np.expm1(-echo.return_rate * dt)) / exists)


def judge(probabilities: Array, hit: NDArray[np.bool_], evidence: Array, expected: Array) -> Array:
    """Return (3, n) probabilities after an image.

    `evidence`: (n,) logarithm of the likelihood of an echo from the object over that of a false alarm, used where
    `hit`; `expected`: (n,) probability that a visible object would have given an echo, used where not. To a silent
    object an echo is a false alarm, as it is where there is nothing.
    """
    weighted = probabilities.copy()
    weighted[VISIBLE] *= np.where(hit, np.exp(np.minimum(evidence, MOST_EVIDENCE)), 1.0 - expected)
    weighted /= weighted.sum(axis=0)
    return weighted
