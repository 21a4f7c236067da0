"""Where echoes come and go: places that show an echo now and then, as a sea-bed does, without an object.

A false alarm of noise is gone in the next image. An echo of a rough sea-bed comes back to its place in one image of
two or three, which chance does not explain any more than it explains an object. What tells them apart is how often: an
object is seen in nearly every image. So the chance that an echo comes back although there is no object is counted, by
place in the fan and in the world, from the tracks that ended as none. An object that is there teaches nothing: its
track does not end.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32
from ods.compiled.kernel import kernel
from ods.messages import Sector
from ods.tracker.state import FlickerState

RANGES, BEARINGS = 10, 9
"""Parts of the fan that are counted apart."""
CELL_M = 2.0
CELLS = 128
"""The world's cells: so large, and so many to the north and to the east; after these they are used anew."""
FAN_MEMORY, WORLD_MEMORY = 0.99, 0.997
"""What an image leaves of the counts of those before: they are of the last 15 and 50 s at 6.7 images a second."""
CALM = 0.003
"""The chance where nothing is known;"""
CALM_LOOKS = 30.0
"""it counts for so many looks in the image as a whole,"""
POOLED_LOOKS = 10.0
"""and that of a larger part (image, ring, part of the fan) for so many in a smaller one (ring, part, world's cell)."""
MOST = 0.6
"""An object that is seen in nearly every image is told from anything that is seen less often than this."""
HITS, LOOKS = 0, 1
ROUNDING = 1e-3
LEAST_LOOKS = 0.01
"""A cell of the world with fewer is forgotten."""


class Places(NamedTuple):
    """Where n tracks are: (n,) each."""

    range_m: Floats
    bearing: Floats
    """rad."""
    north: Floats
    """m."""
    east: Floats


class _Span(NamedTuple):
    nearest: float
    farthest: float
    port: float
    starboard: float


class Flicker:
    """Echoes after the first one, and images in which they might have come, of tracks that ended as no objects."""

    def __init__(self) -> None:
        self._fan = np.zeros((2, RANGES, BEARINGS))
        self._world = np.zeros((2, CELLS, CELLS), np.float32)

    def state(self) -> FlickerState:
        """Return what was counted."""
        cells = np.flatnonzero(self._world[LOOKS]).astype(np.int32)
        return FlickerState(self._fan.tobytes(), cells.tobytes(), self._world.reshape(2, -1)[:, cells].tobytes())

    def restore(self, state: FlickerState) -> None:
        """Go on with what another one counted. Raises ValueError."""
        fan = np.frombuffer(state.fan).reshape(self._fan.shape)
        cells = np.frombuffer(state.cells, np.int32)
        counts = np.frombuffer(state.counts, np.float32).reshape(2, -1)
        if counts.shape[1] != len(cells) or ((cells < 0) | (cells >= CELLS**2)).any():
            raise ValueError("places of echoes that are none")
        for table in (fan, counts):
            if not (np.isfinite(table) & (table >= 0.0)).all() or (table[HITS] > table[LOOKS] * (1.0 + ROUNDING)).any():
                raise ValueError("counts of echoes that are none")
        self._fan = fan.copy()
        self._world = np.zeros((2, CELLS, CELLS), np.float32)
        self._world.reshape(2, -1)[:, cells] = counts

    def learn(self, ended: Places, hits: Floats, looks: Floats, sector: Sector) -> None:
        """Take in the tracks that an image ended: (k,) echoes after the first, and looks. Called for every image."""
        _learn(self._fan, self._world, ended, np.array([np.minimum(hits, looks), looks]), _span_of(sector))

    def chance(self, places: Places, sector: Sector) -> Floats:
        """Return (n,) the chance that an echo comes back to each place if there is no object."""
        return _chance(self._fan, self._world, places, _span_of(sector), CALM)


def _span_of(sector: Sector) -> _Span:
    return _Span(sector.range_min_m, sector.range_max_m, sector.bearing_min_rad, sector.bearing_max_rad)


@kernel
def _part(value: float, first: float, last: float, parts: int) -> int:
    share = (value - first) / (last - first)
    return int(min(share * parts, parts - 1.0)) if share > 0.0 else 0


@kernel
def _cell(metres: float) -> int:
    return int(np.floor(metres / CELL_M)) % CELLS


@kernel
def _learn(fan: Floats, world: Floats32, ended: Places, counts: Floats, span: _Span) -> None:
    fan *= FAN_MEMORY
    for i in range(CELLS):
        for j in range(CELLS):
            kept = WORLD_MEMORY if world[LOOKS, i, j] > LEAST_LOOKS else 0.0
            world[HITS, i, j] *= kept
            world[LOOKS, i, j] *= kept
    for k in range(counts.shape[1]):
        ring = _part(ended.range_m[k], span.nearest, span.farthest, RANGES)
        column = _part(ended.bearing[k], span.port, span.starboard, BEARINGS)
        i, j = _cell(ended.north[k]), _cell(ended.east[k])
        for row in range(2):
            fan[row, ring, column] += counts[row, k]
            world[row, i, j] += counts[row, k]


@kernel
def _pooled(hits: float, looks: float, larger: float, weight: float) -> float:
    """Return the chance in a part, of its own counts and of that in the larger part."""
    return (hits + weight * larger) / (looks + weight)


@kernel
def _chance(fan: Floats, world: Floats32, places: Places, span: _Span, prior: float) -> Floats:
    hits, looks = fan[HITS], fan[LOOKS]
    whole = _pooled(hits.sum(), looks.sum(), prior, CALM_LOOKS)
    rings = np.empty(RANGES)
    for r in range(RANGES):
        rings[r] = _pooled(hits[r].sum(), looks[r].sum(), whole, POOLED_LOOKS)
    chance = np.empty(len(places.range_m))
    for k in range(len(chance)):
        r = _part(places.range_m[k], span.nearest, span.farthest, RANGES)
        c = _part(places.bearing[k], span.port, span.starboard, BEARINGS)
        i, j = _cell(places.north[k]), _cell(places.east[k])
        in_fan = _pooled(hits[r, c], looks[r, c], rings[r], POOLED_LOOKS)
        chance[k] = min(_pooled(world[HITS, i, j], world[LOOKS, i, j], in_fan, POOLED_LOOKS), MOST)
    return chance
