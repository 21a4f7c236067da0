"""Does an object exist? A chain of three hidden states an object, fed with hits and misses.

Integrated probabilistic data association (IPDA): D. Musicki, R. Evans, S. Stankovic, IEEE Trans. Automatic Control
39(6), 1994; its second form, in which an object that exists may be undetectable for a while.

Rows of the (4, n) probabilities: VISIBLE (exists and gives echoes), SILENT (exists, gives none from here just now),
NOTHING (a false track, or the object is gone) and SPOT (a place where echoes come and go, as on a rough sea-bed: see
`flicker`). Missing an object in some images is normal [SSIE]: the silent state keeps a well-established object alive
through a silence that would end a young one. Bodies and spots are told apart by how often they are seen, how strong
they are and whether they move.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.compiled.kernel import kernel
from ods.tracker.settings import EchoSettings

VISIBLE, SILENT, NOTHING, SPOT = 0, 1, 2, 3
EXISTENCE_STATES = 4
YOUNG = 300.0
"""An object seen once is lost so many times sooner than an old one; the excess falls with the number of echoes."""
SMALLEST = 1e-300
BODY_SEEN, BODY_LOOKS = 0.85, 8.0
"""An object is seen in so many of the images; that counts for so many of them, its own count for the rest."""
SPOT_SEEN, SPOT_LOOKS = 0.3, 20.0
"""The same of a spot."""
MOST_MOTION = 6.0
"""Largest logarithm of a likelihood ratio that motion alone gives."""
LEAST_MISSED = 1e-3
"""No echo is that sure."""
MOST_EVIDENCE = 30.0
"""Largest log-likelihood ratio of one echo; e^30 leaves nothing of any doubt."""


def carry_on(probabilities: Floats, echoes: Ints, watched: Floats, dt: float, echo: EchoSettings) -> Floats:
    """Return (4, n) probabilities `dt` seconds later.

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
        carried[SPOT, i] = probabilities[SPOT, i]
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


class Returns(NamedTuple):
    """How often n objects have an echo, if they are bodies and if they are spots: (n,) each, over the setting's."""

    body: Floats
    spot: Floats


def returns(hits: Floats, looks: Floats, detection_probability: float) -> Returns:
    """Return how often objects have an echo, by (n,) echoes in so many looks.

    What is not known beforehand is what an image's echo, or its absence, says by the beta distribution: a spot that is
    seen again and again is one that is seen often, and each further echo proves less.
    """
    body = (hits + BODY_LOOKS * BODY_SEEN) / (looks + BODY_LOOKS)
    spot = (hits + SPOT_LOOKS * SPOT_SEEN) / (looks + SPOT_LOOKS)
    return Returns(body / detection_probability, spot / detection_probability)


@kernel
def after_image(probabilities: Floats, hit: Mask, llr: Floats, expected: Floats, often: Returns) -> Floats:
    """Return (4, n) probabilities after an image.

    `llr`: (n,) logarithm of the likelihood of an echo from the object over that of a false alarm, used where
    `hit`; `expected`: (n,) probability that a visible object would have given an echo. To a silent object, and where
    there is nothing, an echo is a false alarm; it may be one beside a visible object and a spot, too, that were missed.
    """
    judged = np.empty_like(probabilities)
    for i in range(len(hit)):
        weight = math.exp(min(llr[i], MOST_EVIDENCE)) if hit[i] else 0.0
        visible = probabilities[VISIBLE, i] * _likelihood(often.body[i], expected[i], weight)
        spot = probabilities[SPOT, i] * _likelihood(often.spot[i], expected[i], weight)
        silent, nothing = probabilities[SILENT, i], probabilities[NOTHING, i]
        total = visible + silent + nothing + spot
        judged[VISIBLE, i], judged[SILENT, i] = visible / total, silent / total
        judged[NOTHING, i], judged[SPOT, i] = nothing / total, spot / total
    return judged


@kernel
def _likelihood(often: float, expected: float, weight: float) -> float:
    return max(1.0 - expected * often, LEAST_MISSED) + weight * often


def told_apart(probabilities: Floats, from_nothing: Floats, from_spot: Floats) -> Floats:
    """Return (4, n) probabilities given (n,) log-likelihood ratios of a body over nothing and over a spot."""
    judged = probabilities.copy()
    judged[NOTHING] *= np.exp(-from_nothing)
    judged[SPOT] *= np.exp(-from_spot)
    return np.asarray(judged / judged.sum(axis=0))


def evidence_of_motion(static: Floats, static_prior: float) -> Floats:
    """Return (n,) the log-likelihood ratio of a body over a spot, which does not move, by `static` of `Estimate`."""
    moves = np.log(static_prior / np.maximum(static, SMALLEST))
    return np.asarray(np.clip(moves, 0.0, MOST_MOTION))
