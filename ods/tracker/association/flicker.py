"""Where echoes come and go: places that show an echo now and then, as a sea-bed does, without an object.

A false alarm of noise is gone in the next image. An echo of a rough sea-bed comes back to its place in one image of
two or three, which chance does not explain any more than it explains an object: such a place is a spot. How many of the
echoes of nothing are of spots is counted, by place in the fan and in the world, from the tracks that ended as no
objects: what came of them tells how likely each was one (`existence`). An object that is there teaches nothing: its
track does not end.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32, Ints
from ods.compiled import native
from ods.messages import Sector
from ods.tracker.state import FlickerState

RANGES, BEARINGS = 10, 9
"""Parts of the fan that are counted apart."""
CELLS = 128
"""The world's cells: so many to the north and to the east."""
FAN_MEMORY, WORLD_MEMORY = 0.99, 0.997
"""What an image leaves of the counts of those before: they are of the last 15 and 50 s at 6.7 images a second."""
CALM = 1e-4
"""The share of spots where nothing is known, and an image has no echoes of nothing that tell their strength;"""
NEW = 0.1
"""what it rises by towards many of them: a chain's levels leave next to none of noise, so they are of a bottom;"""
MANY = 10.0
"""so many are half of the way;"""
CALM_TRACKS = 30.0
"""it counts for so many tracks in the image as a whole,"""
POOLED_TRACKS = 10.0
"""and that of a larger part (image, ring, part of the fan) for so many in a smaller one (ring, part, world's cell)."""
MOST = 0.8
"""Some echoes are of noise everywhere."""
SPOTS, TRACKS = 0, 1
ROUNDING = 1e-3


class Places(NamedTuple):
    """Where n tracks are: (n,) each."""

    range_m: Floats
    bearing: Floats
    """rad."""
    north: Floats
    """m."""
    east: Floats


class World(NamedTuple):
    """Counts by the world's cells, which fade from image to image: brought up to date when they are needed."""

    counts: Floats32
    """(2, CELLS, CELLS) of spots and of tracks,"""
    image: Ints
    """(CELLS, CELLS) as of this image."""


class _Span(NamedTuple):
    nearest: float
    farthest: float
    port: float
    starboard: float


class Flicker:
    """Tracks that ended as no objects, and how many of them were of spots."""

    def __init__(self) -> None:
        self._fan = np.zeros((2, RANGES, BEARINGS))
        self._images = 0
        self._world = World(np.zeros((2, CELLS, CELLS), np.float32), np.zeros((CELLS, CELLS), np.int64))

    def state(self) -> FlickerState:
        """Return what was counted."""
        cells, counts = np.empty(CELLS**2, np.int32), np.empty((2, CELLS**2), np.float32)
        found = native.flicker_left(self._world, self._images, WORLD_MEMORY, cells, counts)
        return FlickerState(self._fan.tobytes(), cells[:found].tobytes(), counts[:, :found].tobytes())

    def restore(self, state: FlickerState) -> None:
        """Go on with what another one counted. Raises ValueError."""
        fan = np.frombuffer(state.fan).reshape(self._fan.shape)
        cells = np.frombuffer(state.cells, np.int32)
        counts = np.frombuffer(state.counts, np.float32).reshape(2, -1)
        if counts.shape[1] != len(cells) or ((cells < 0) | (cells >= CELLS**2)).any():
            raise ValueError("places of echoes that are none")
        for table in (fan, counts):
            more = table[SPOTS] > table[TRACKS] * (1.0 + ROUNDING)
            if not (np.isfinite(table) & (table >= 0.0)).all() or more.any():
                raise ValueError("counts of echoes that are none")
        self._fan = fan.copy()
        self._images = 0
        self._world = World(np.zeros((2, CELLS, CELLS), np.float32), np.zeros((CELLS, CELLS), np.int64))
        self._world.counts.reshape(2, -1)[:, cells] = counts

    def learn(self, places: Places, counts: Floats, sector: Sector) -> None:
        """Take in the tracks at n places that an image ended: (2, n) probabilities of spots, and of no objects.

        Called for every image; others are 0.
        """
        self._fan *= FAN_MEMORY
        self._images += 1
        world = self._world, self._images, WORLD_MEMORY
        native.flicker_learn(self._fan, world, places, _span_of(sector), counts)

    def share(self, places: Places, sector: Sector, per_scan: float) -> Floats:
        """Return (n,) the share of spots among echoes of nothing at each place.

        per_scan: echoes of nothing in an image that tell their strength.
        """
        prior = CALM + NEW * per_scan**2 / (per_scan**2 + MANY**2)
        world, found = (self._world, self._images, WORLD_MEMORY), np.empty(len(places.range_m))
        how = prior, CALM_TRACKS, POOLED_TRACKS, MOST
        native.flicker_share(how, found, self._fan, world, places, _span_of(sector))
        return found


def _span_of(sector: Sector) -> _Span:
    return _Span(sector.range_min_m, sector.range_max_m, sector.bearing_min_rad, sector.bearing_max_rad)
