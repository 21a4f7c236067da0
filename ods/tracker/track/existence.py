"""Does an object exist? A chain of three hidden states an object, fed with hits and misses.

Integrated probabilistic data association (IPDA): D. Musicki, R. Evans, S. Stankovic, IEEE Trans. Automatic Control
39(6), 1994; its second form, in which an object that exists may be undetectable for a while.

The states (`Chain`) are visible (exists and gives echoes), silent (exists, gives none from here just now), nothing (a
false track, or the object is gone) and spot (a place where echoes come and go, as on a rough sea-bed: see `flicker`).
Missing an object in some images is normal [SSIE]: the silent state keeps a well-established object alive
through a silence that would end a young one. Bodies and spots are told apart by how often they are seen, how strong
their echoes are and how these set in.
"""

from typing import NamedTuple

import numpy as np

from ods.compiled import native

BODY_SEEN, BODY_LOOKS = 0.85, 8.0
"""An object is seen in so many of the images; that counts for so many of them, its own count for the rest."""
SPOT_SEEN, SPOT_LOOKS, SPOT_LOOKS_IN_CROWD = 0.3, 12.0, 8.0
"""The same of a spot, and of one in a crowd (see `crowd`), where more are seen in nearly all images."""
SEEN = np.array([BODY_SEEN, BODY_LOOKS, SPOT_SEEN, SPOT_LOOKS, SPOT_LOOKS_IN_CROWD])
"""For C: `Seen`."""


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


def carried_on(chain: Chain, echoes: int, watched: float, dt: float, rates: Rates) -> Chain:
    """Return the probabilities `dt` seconds later.

    `watched`: share of the time that the object was in the sonar's view: only there does it fall silent or come back.
    `echoes`: so far; a young object is more often an error of association, and in view is lost sooner.
    """
    after = np.empty(4)
    native.existence_carried_on(chain, echoes, watched, dt, rates, after)
    return Chain(*after.tolist())


def how_often(hits: float, looks: float, detection_probability: float, crowd: float) -> Often:
    """Return how often an object has an echo, by its echoes in so many looks. `crowd`: of `doubt.Spots`."""
    often = np.empty(2)
    native.existence_how_often(hits, looks, detection_probability, crowd, SEEN, often)
    return Often(*often.tolist())


def after_image(chain: Chain, hit: bool, llr: float, expected: float, often: Often) -> Chain:
    """Return the probabilities after an image.

    `llr`: logarithm of the likelihood of an echo from the object over that of a false alarm, used where `hit`;
    `expected`: probability that a visible object would have given an echo.
    """
    after = np.empty(4)
    native.existence_after_image(chain, hit, llr, expected, often, after)
    return Chain(*after.tolist())


def told_apart(chain: Chain, from_nothing: float, from_spot: float) -> Chain:
    """Return the probabilities given log-likelihood ratios of a body over nothing and over a spot."""
    after = np.empty(4)
    native.existence_told_apart(chain, from_nothing, from_spot, after)
    return Chain(*after.tolist())
