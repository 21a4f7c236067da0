"""How far a place's echoes wander along the range: a body gives them where it is, a rough bottom wherever it shines.

What shines of a patch of bottom, and so the middle of its echo, changes from image to image within the patch. How far
is counted from the tracks that ended as spots, as it depends on bottom and sonar.
"""

import math

import numpy as np

from ods.compiled import native
from ods.tracker.state import WanderState

FIRST_M = 0.85
"""Root mean square of what spots wander where nothing is known, which counts for"""
FIRST_ECHOES = 200.0
"""so many echoes."""
MEMORY = 0.997
"""What an image leaves of the counts of those before: they are of the last 50 s at 6.7 images a second."""
BODY_SHARE = 0.5
"""A body's echoes wander by this share of it,"""
SURE = 12.0
"""and either is known beforehand as well as so many echoes tell it."""
MOST_FOR, MOST_IN_CROWD, MOST_AGAINST = 8.0, 2.0, 1.0
"""Largest logarithm of a likelihood ratio that this alone gives for a body, for one in a crowd (see `crowd`), and
against one: those of large bodies wander, too."""
LAW = np.array([BODY_SHARE, SURE, MOST_FOR, MOST_IN_CROWD, MOST_AGAINST])
"""For C: `WanderLaw`."""


class Wander:
    """Sums over the echoes of tracks that ended as spots."""

    def __init__(self) -> None:
        self._squares, self._echoes = 0.0, 0.0

    def state(self) -> WanderState:
        """Return what was counted."""
        return WanderState(self._squares, self._echoes)

    def restore(self, state: WanderState) -> None:
        """Go on with what another one counted. Raises ValueError."""
        if not all(math.isfinite(x) and x >= 0.0 for x in (state.squares, state.echoes)):
            raise ValueError("echoes that wander by what is no number")
        self._squares, self._echoes = state.squares, state.echoes

    def learn(self, squares: float, echoes: float) -> None:
        """Take in the tracks that an image ended as spots: sum of squares, m2, of so many echoes. For every image."""
        self._squares = MEMORY * self._squares + squares
        self._echoes = MEMORY * self._echoes + echoes

    @property
    def of_spots_m2(self) -> float:
        """Mean square of what the echoes of spots wander, m2."""
        return (self._squares + FIRST_ECHOES * FIRST_M**2) / (self._echoes + FIRST_ECHOES)


def evidence(squares: float, echoes: float, of_spots_m2: float, crowd: float) -> float:
    """Return the log-likelihood ratio of a body over a spot by the sum of squares, m2, of so many echoes.

    `crowd`: of `Spots`.
    """
    ratio: float = native.wander_evidence(squares, echoes, of_spots_m2, crowd, LAW)
    return ratio
