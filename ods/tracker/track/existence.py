"""Does an object exist? A chain of three hidden states an object, fed with hits and misses.

Integrated probabilistic data association (IPDA): D. Musicki, R. Evans, S. Stankovic, IEEE Trans. Automatic Control
39(6), 1994; its second form, in which an object that exists may be undetectable for a while.

Rows of the (3, n) probabilities: VISIBLE (exists and gives echoes), SILENT (exists, gives none from here just now) and
NOTHING (a false track, or the object is gone). Missing an object in some images is normal [SSIE]: the silent state
keeps a well-established object alive through a silence that would end a young one.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.compiled.kernel import kernel
from ods.tracker.settings import EchoSettings

VISIBLE, SILENT, NOTHING = 0, 1, 2
EXISTENCE_STATES = 3
YOUNG = 300.0
"""An object seen once is lost so many times sooner than an old one; the excess falls with the number of echoes."""
SMALLEST = 1e-300
MASKED = 0.5
"""Share of the echoes that come and go that are taken to mask an object's own."""
MOST_EVIDENCE = 30.0
"""Largest log-likelihood ratio of one echo; e^30 leaves nothing of any doubt."""


def carry_on(probabilities: Floats, echoes: Ints, watched: Floats, dt: float, echo: EchoSettings) -> Floats:
    """Return (3, n) probabilities `dt` seconds later.

    `watched`: (n,) share of the time that the object was in the sonar's view: only there does it fall silent or come
    back. `echoes`: (n,) so far; a young object is more often an error of association, and in view is lost sooner.
    """
    return _carry_on(probabilities, echoes, watched, dt, Rates(echo.silence_rate, echo.return_rate, echo.loss_rate))


class Rates(NamedTuple):
    """How often an object falls silent, gives echoes again, and is lost: 1/s each."""

    silence: float
    recovery: float
    loss: float


@kernel
def _carry_on(probabilities: Floats, echoes: Ints, watched: Floats, dt: float, rates: Rates) -> Floats:
    carried = np.empty_like(probabilities)
    for i in range(len(echoes)):
        visible, silent, nothing = probabilities[VISIBLE, i], probabilities[SILENT, i], probabilities[NOTHING, i]
        time = dt * watched[i]
        falls_silent = visible * -math.expm1(-rates.silence * time)
        returns = silent * -math.expm1(-rates.recovery * time)
        lost = -math.expm1(-rates.loss * (dt + time * YOUNG / echoes[i]))
        moved = returns - falls_silent
        carried[VISIBLE, i] = (1.0 - lost) * (visible + moved)
        carried[SILENT, i] = (1.0 - lost) * (silent - moved)
        carried[NOTHING, i] = nothing + lost * (visible + silent)
    return carried


def visibility(probabilities: Floats, dt: float, echo: EchoSettings) -> Floats:
    """Return (n,) the probability that an object, if it exists, gives echoes `dt` seconds later."""
    return _visibility(probabilities, -math.expm1(-echo.return_rate * dt))


@kernel
def _visibility(probabilities: Floats, returned: float) -> Floats:
    visibility = np.empty(probabilities.shape[1])
    for i in range(len(visibility)):
        visible, silent = probabilities[VISIBLE, i], probabilities[SILENT, i]
        visibility[i] = (visible + silent * returned) / max(visible + silent, SMALLEST)
    return visibility


@kernel
def after_image(probabilities: Floats, hit: Mask, llr: Floats, expected: Floats, flicker: Floats) -> Floats:
    """Return (3, n) probabilities after an image.

    `llr`: (n,) logarithm of the likelihood of an echo from the object over that of a false alarm, used where
    `hit`; `expected`: (n,) probability that a visible object would have given an echo, used where not. To a silent
    object an echo is a false alarm. Where there is nothing it is one, too, or it has come back to a place where echoes
    come and go: `flicker`, (n,) how often it does. These echoes mask some of an object's own.
    """
    judged = np.empty_like(probabilities)
    for i in range(len(hit)):
        if hit[i]:
            weight = math.exp(min(llr[i], MOST_EVIDENCE))
            by_itself = 1.0 + flicker[i] * weight
        else:
            weight = 1.0 - expected[i] * (1.0 - MASKED * flicker[i])
            by_itself = 1.0 - expected[i] * flicker[i]
        visible = weight * probabilities[VISIBLE, i]
        silent, nothing = probabilities[SILENT, i], by_itself * probabilities[NOTHING, i]
        total = visible + silent + nothing
        judged[VISIBLE, i], judged[SILENT, i], judged[NOTHING, i] = visible / total, silent / total, nothing / total
    return judged
