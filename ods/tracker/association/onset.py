"""How sharply a place's echoes set in: a body's face is met at once, a rough bottom begins to shine slowly.

The highest level of a body's echo follows half of that within about the width of a point in most images, where what
shines of a patch of bottom lies as far before its highest level as behind. How often is not the same for all bodies,
nor for all spots, so it is judged by the share of the echoes that are sharp, and not anew by each; and how often those
of spots are is counted from the tracks that ended as spots, as over gravel and short ripples they nearly are as often
as bodies' are.
"""

import math

import numpy as np

from ods.compiled import native
from ods.tracker.state import OnsetState

SHARP = 1.06
"""Widths of a point: an echo that sets in within this is sharp."""
BODY_SHARP, BODY_SLOW = 3.0, 1.5
"""A body's echoes are sharp, and not, as often as the beta distribution of these says;"""
SPOT_LOOKS = 7.0
"""those of a spot as often as others', which counts for so many of its own."""
FIRST = 0.09
"""Share of the echoes of spots that are sharp where nothing is known, which counts for"""
FIRST_ECHOES = 20.0
"""so many echoes."""
MOST = 0.95
"""Some echoes of any spot are slow."""
ROUNDING = 1e-9
MEMORY = 0.997
"""What an image leaves of the counts of those before: they are of the last 50 s at 6.7 images a second."""
MOST_FOR, MOST_AGAINST = 3.0, 6.0
"""Largest logarithm of a likelihood ratio that this alone gives for a body, and against one,"""
ENOUGH = 8.0
"""which takes so many echoes."""
DEARER = 3.3
"""So many times the odds a new object needs where echoes tell their onset: sharp ones bring more than that."""
LAW = np.array([SHARP, BODY_SHARP, BODY_SLOW, SPOT_LOOKS, MOST_FOR, MOST_AGAINST, ENOUGH])
"""For C: `OnsetLaw`."""


class Onset:
    """Counts of the echoes of tracks that ended as spots."""

    def __init__(self) -> None:
        self._sharp, self._echoes = 0.0, 0.0

    def state(self) -> OnsetState:
        """Return what was counted."""
        return OnsetState(self._sharp, self._echoes)

    def restore(self, state: OnsetState) -> None:
        """Go on with what another one counted. Raises ValueError."""
        if not (math.isfinite(state.echoes) and 0.0 <= state.sharp <= state.echoes * (1.0 + ROUNDING)):
            raise ValueError("echoes of spots that are none")
        self._sharp, self._echoes = state.sharp, state.echoes

    def learn(self, sharp: float, echoes: float) -> None:
        """Take in the tracks that an image ended as spots: so many sharp ones of so many echoes. For every image."""
        self._sharp = MEMORY * self._sharp + sharp
        self._echoes = MEMORY * self._echoes + echoes

    @property
    def of_spots(self) -> float:
        """Share of the echoes of spots that are sharp."""
        share = (self._sharp + FIRST_ECHOES * FIRST) / (self._echoes + FIRST_ECHOES)
        return min(share, MOST)


def evidence(sharp: float, echoes: float, of_spots: float) -> float:
    """Return the log-likelihood ratio of a body over a spot by how many of so many echoes are sharp: beta-binomial."""
    ratio: float = native.onset_evidence(sharp, echoes, of_spots, LAW)
    return ratio
