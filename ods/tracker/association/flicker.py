"""Which share of the echoes of nothing are of spots: places that show an echo now and then, without an object.

A false alarm of noise is gone in the next image. An echo of a rough sea-bed comes back to its place in one image of
two or three, which chance does not explain any more than it explains an object: such a place is a spot. Their share is
counted from the tracks that ended as no objects: what came of them tells how likely each was one (`existence`). An
object that is there teaches nothing: its track does not end.
"""

import math

from ods.tracker.state import FlickerState

MEMORY = 0.99
"""What an image leaves of the counts of those before: they are of the last 15 s at 6.7 images a second."""
CALM = 1e-4
"""The share of spots where nothing is known, and an image has no echoes of nothing that tell their strength;"""
NEW = 0.1
"""what it rises by towards many of them: a chain's levels leave next to none of noise, so they are of a bottom;"""
MANY = 10.0
"""so many are half of the way;"""
CALM_TRACKS = 30.0
"""it counts for so many tracks."""
MOST = 0.8
"""Some echoes are of noise everywhere."""
ROUNDING = 1e-9


class Flicker:
    """Tracks that ended as no objects, and how many of them were of spots."""

    def __init__(self) -> None:
        self._spots, self._tracks = 0.0, 0.0

    def state(self) -> FlickerState:
        """Return what was counted."""
        return FlickerState(self._spots, self._tracks)

    def restore(self, state: FlickerState) -> None:
        """Go on with what another one counted. Raises ValueError."""
        if not (math.isfinite(state.tracks) and 0.0 <= state.spots <= state.tracks * (1.0 + ROUNDING)):
            raise ValueError("tracks of spots that are none")
        self._spots, self._tracks = state.spots, state.tracks

    def learn(self, spots: float, tracks: float) -> None:
        """Take in the tracks that an image ended: how many were of spots, and of no objects. For every image."""
        self._spots = MEMORY * self._spots + spots
        self._tracks = MEMORY * self._tracks + tracks

    def share(self, per_scan: float) -> float:
        """Return the share of spots; per_scan: echoes of nothing in an image that tell their strength."""
        prior = CALM + NEW * per_scan**2 / (per_scan**2 + MANY**2)
        return min((self._spots + CALM_TRACKS * prior) / (self._tracks + CALM_TRACKS), MOST)
