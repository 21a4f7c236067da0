"""Does an object exist? A chain of three hidden states an object, fed with hits and misses.

Integrated probabilistic data association (IPDA): D. Musicki, R. Evans, S. Stankovic, IEEE Trans. Automatic Control
39(6), 1994; its second form, in which an object that exists may be undetectable for a while.

The states (`Chain`) are visible (exists and gives echoes), silent (exists, gives none from here just now), nothing (a
false track, or the object is gone) and spot (a place where echoes come and go, as on a rough sea-bed: see `flicker`).
Missing an object in some images is normal [SSIE]: the silent state keeps a well-established object alive
through a silence that would end a young one. Bodies and spots are told apart by how often they are seen, how strong
they are and whether they move.
"""

import math
from typing import NamedTuple

from ods.compiled.kernel import kernel
from ods.tracker.measurement.scan import LARGEST_PATCH_M

YOUNG = 300.0
"""An object seen once is lost so many times sooner than an old one; the excess falls with the number of echoes."""
SMALLEST = 1e-300
BODY_SEEN, BODY_LOOKS = 0.85, 8.0
"""An object is seen in so many of the images; that counts for so many of them, its own count for the rest."""
SPOT_SEEN, SPOT_LOOKS, SPOT_LOOKS_IN_CROWD = 0.3, 12.0, 8.0
"""The same of a spot, and of one in a crowd (see `crowd`), where more are seen in nearly all images."""
MOST_MOTION, MOST_MOTION_IN_CROWD = 6.0, 2.5
"""Largest logarithm of a likelihood ratio that motion alone gives, and that it gives in a crowd."""
LARGE = 3.0
"""Logarithm of the likelihood ratio that size alone gives: what is larger than a patch of bottom is hardly a spot."""
LEAST_MISSED = 1e-3
"""No echo is that sure."""
MOST_EVIDENCE = 30.0
"""Largest log-likelihood ratio of one echo; e^30 leaves nothing of any doubt."""


class Chain(NamedTuple):
    """Probabilities of the four states of one object."""

    visible: float
    silent: float
    nothing: float
    spot: float


class Rates(NamedTuple):
    """How often an object falls silent, gives echoes again, and is lost: 1/s each."""

    silence: float
    recovery: float
    loss: float


class Often(NamedTuple):
    """How often an object has an echo, if it is a body and if it is a spot, over the setting's."""

    body: float
    spot: float


@kernel
def carried_on(chain: Chain, echoes: int, watched: float, dt: float, rates: Rates) -> Chain:
    """Return the probabilities `dt` seconds later.

    `watched`: share of the time that the object was in the sonar's view: only there does it fall silent or come back.
    `echoes`: so far; a young object is more often an error of association, and in view is lost sooner.
    """
    time = dt * watched
    falls_silent = chain.visible * -math.expm1(-rates.silence * time)
    returns = chain.silent * -math.expm1(-rates.recovery * time)
    lost = -math.expm1(-rates.loss * (dt + time * YOUNG / echoes))
    moved = returns - falls_silent
    return Chain(
        (1.0 - lost) * (chain.visible + moved),
        (1.0 - lost) * (chain.silent - moved),
        chain.nothing + lost * (chain.visible + chain.silent),
        chain.spot,
    )


@kernel
def how_often(hits: float, looks: float, detection_probability: float, crowd: float) -> Often:
    """Return how often an object has an echo, by its echoes in so many looks.

    What is not known beforehand is what an image's echo, or its absence, says by the beta distribution: a spot that is
    seen again and again is one that is seen often, and each further echo proves less. `crowd`: of `doubt.Spots`.
    """
    body = (hits + BODY_LOOKS * BODY_SEEN) / (looks + BODY_LOOKS)
    spots_looks = SPOT_LOOKS + crowd * (SPOT_LOOKS_IN_CROWD - SPOT_LOOKS)
    spot = (hits + spots_looks * SPOT_SEEN) / (looks + spots_looks)
    return Often(body / detection_probability, spot / detection_probability)


@kernel
def after_image(chain: Chain, hit: bool, llr: float, expected: float, often: Often) -> Chain:
    """Return the probabilities after an image.

    `llr`: logarithm of the likelihood of an echo from the object over that of a false alarm, used where `hit`;
    `expected`: probability that a visible object would have given an echo. To a silent object, and where there is
    nothing, an echo is a false alarm; it may be one beside a visible object and a spot, too, that were missed.
    """
    weight = math.exp(min(llr, MOST_EVIDENCE)) if hit else 0.0
    visible = chain.visible * _likelihood(often.body, expected, weight)
    return _normalized(visible, chain.silent, chain.nothing, chain.spot * _likelihood(often.spot, expected, weight))


@kernel
def _likelihood(often: float, expected: float, weight: float) -> float:
    return max(1.0 - expected * often, LEAST_MISSED) + weight * often


@kernel
def told_apart(chain: Chain, from_nothing: float, from_spot: float) -> Chain:
    """Return the probabilities given log-likelihood ratios of a body over nothing and over a spot."""
    nothing, spot = chain.nothing * math.exp(-from_nothing), chain.spot * math.exp(-from_spot)
    return _normalized(chain.visible, chain.silent, nothing, spot)


@kernel
def _normalized(visible: float, silent: float, nothing: float, spot: float) -> Chain:
    total = visible + silent + nothing + spot
    return Chain(visible / total, silent / total, nothing / total, spot / total)


@kernel
def evidence_of_motion(static: float, static_prior: float, crowd: float) -> float:
    """Return the log-likelihood ratio of a body over a spot, which does not move, by `static` of `Belief`.

    `crowd`: of `doubt.Spots`.
    """
    most = MOST_MOTION + crowd * (MOST_MOTION_IN_CROWD - MOST_MOTION)
    return min(max(math.log(static_prior / max(static, SMALLEST)), 0.0), most)


@kernel
def evidence_of_size(radius: float) -> float:
    """Return the log-likelihood ratio of a body over a spot by its radius, m."""
    return LARGE if radius > LARGEST_PATCH_M else 0.0
