"""How a place's echoes set in, by the chain's judgement of their fronts: as a body's do, or as a rough bottom's.

Where levels rise with a bottom's crests the chain tells of each echo how likely its front is a body's
(`ods.pipeline.fronts`). A crest keeps its shape from image to image, so that the next echo tells little that the last
one did not; but as the vehicle goes on it shows other sides. So an object is judged by the mean of its last echoes'
log-odds, and that counts for more the more of them there are, up to a limit. How the echoes of spots are judged is
counted from the tracks that ended as spots, as real beds need not be like those that the network was learnt from.
"""

import math

import numpy as np

from ods.compiled import native
from ods.tracker.state import FrontState

SURE = 1e-4
"""No front is more likely a body's than 1 less this, or less likely than this."""
BODY = 5.2
"""Mean of the log-odds of bodies' fronts: lower than of most, as those among crests count."""
FIRST, FIRST_ECHOES = -2.2, 200.0
"""Mean of spots' where nothing is known, which counts for so many echoes."""
MOST = 4.0
"""Highest mean of spots' that is believed."""
VARIANCE, FEW = 2.5, 6.0
"""Variance of what does not average away, for either; a mean of n echoes has 1 + FEW / n times that."""
MOST_FOR, MOST_AGAINST = 9.0, 3.0
"""Largest logarithm of a likelihood ratio that this alone gives for a body, and against one."""
MEMORY = 0.997
"""What an image leaves of the counts of those before: they are of the last 50 s at 6.7 images a second."""
LAW = np.array([SURE, BODY, VARIANCE, FEW, MOST_FOR, MOST_AGAINST])
"""For C: `FrontLaw`."""


class Front:
    """Sums over the echoes of tracks that ended as spots."""

    def __init__(self) -> None:
        self._total, self._echoes = 0.0, 0.0

    def state(self) -> FrontState:
        """Return what was counted."""
        return FrontState(self._total, self._echoes)

    def restore(self, state: FrontState) -> None:
        """Go on with what another one counted. Raises ValueError."""
        if not (math.isfinite(state.total) and math.isfinite(state.echoes) and state.echoes >= 0.0):
            raise ValueError("fronts of spots that are none")
        self._total, self._echoes = state.total, state.echoes

    def learn(self, total: float, echoes: float) -> None:
        """Take in the tracks that an image ended as spots: sum of log-odds over so many echoes. For every image."""
        self._total = MEMORY * self._total + total
        self._echoes = MEMORY * self._echoes + echoes

    @property
    def of_spots(self) -> float:
        """Mean of the log-odds of spots' fronts."""
        return min((self._total + FIRST_ECHOES * FIRST) / (self._echoes + FIRST_ECHOES), MOST)


def log_odds(front: float) -> float:
    """Return the logarithm of the odds of a front as `Detection` tells it."""
    odds: float = native.front_log_odds(front, LAW)
    return odds


def evidence(total: float, echoes: float, of_spots: float) -> float:
    """Return the log-likelihood ratio of a body over a spot by the sum of the log-odds of so many echoes: normal."""
    ratio: float = native.front_evidence(total, echoes, of_spots, LAW)
    return ratio
