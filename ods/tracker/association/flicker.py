"""Where echoes come and go: places that show an echo now and then, as a sea-bed does, without an object.

A false alarm of noise is gone in the next image. An echo of a rough sea-bed comes back to its place in one image of
two or three, which chance does not explain any more than it explains an object: such a place is a spot. How many of the
echoes of nothing are of spots is counted, by place in the fan and in the world, from the tracks that ended as no
objects: what came of them tells how likely each was one (`existence`). An object that is there teaches nothing: its
track does not end.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32, Ints, Ints32
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
LEAST_TRACKS = 0.01
"""A cell of the world with fewer is forgotten."""


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
        cells, counts = _left(self._world, self._images)
        return FlickerState(self._fan.tobytes(), cells.tobytes(), counts.tobytes())

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
        _learn(self._fan, self._world, self._images, places, counts, _span_of(sector))

    def share(self, places: Places, sector: Sector, per_scan: float) -> Floats:
        """Return (n,) the share of spots among echoes of nothing at each place.

        per_scan: echoes of nothing in an image that tell their strength.
        """
        prior = CALM + NEW * per_scan**2 / (per_scan**2 + MANY**2)
        return _share(self._fan, self._world, self._images, places, _span_of(sector), prior)


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
def _kept(world: World, i: int, j: int, images: int) -> float:
    """Return the share of its counts that is left of a cell's after so many images."""
    tracks, since = world.counts[TRACKS, i, j], images - world.image[i, j]
    if since == 0 or tracks == 0.0:
        return 1.0
    before = math.exp((since - 1.0) * math.log(WORLD_MEMORY))
    return before * WORLD_MEMORY if before * tracks > LEAST_TRACKS else 0.0


@kernel
def _left(world: World, images: int) -> tuple[Ints32, Floats32]:
    """Return (k,) numbers of the cells that have counts, and (2, k) these."""
    cells, counts, found = np.empty(CELLS**2, np.int32), np.empty((2, CELLS**2), np.float32), 0
    for i in range(CELLS):
        for j in range(CELLS):
            if world.counts[TRACKS, i, j] > 0.0:
                kept = _kept(world, i, j, images)
                cells[found] = CELLS * i + j
                counts[SPOTS, found] = world.counts[SPOTS, i, j] * kept
                counts[TRACKS, found] = world.counts[TRACKS, i, j] * kept
                found += kept > 0.0
    return cells[:found].copy(), counts[:, :found].copy()


@kernel
def _learn(fan: Floats, world: World, images: int, places: Places, counts: Floats, span: _Span) -> None:
    for k in range(counts.shape[1]):
        if counts[TRACKS, k] == 0.0:
            continue
        ring = _part(places.range_m[k], span.nearest, span.farthest, RANGES)
        column = _part(places.bearing[k], span.port, span.starboard, BEARINGS)
        i, j = _cell(places.north[k]), _cell(places.east[k])
        kept, world.image[i, j] = _kept(world, i, j, images), images
        for row in range(2):
            count = min(counts[row, k], counts[TRACKS, k])
            fan[row, ring, column] += count
            world.counts[row, i, j] = kept * world.counts[row, i, j] + count


@kernel
def _pooled(spots: float, tracks: float, larger: float, weight: float) -> float:
    """Return the share in a part, of its own counts and of that in the larger part."""
    return (spots + weight * larger) / (tracks + weight)


@kernel
def _share(fan: Floats, world: World, images: int, places: Places, span: _Span, prior: float) -> Floats:
    spots, tracks = fan[SPOTS], fan[TRACKS]
    whole = _pooled(spots.sum(), tracks.sum(), prior, CALM_TRACKS)
    rings = np.empty(RANGES)
    for r in range(RANGES):
        rings[r] = _pooled(spots[r].sum(), tracks[r].sum(), whole, POOLED_TRACKS)
    share = np.empty(len(places.range_m))
    for k in range(len(share)):
        r = _part(places.range_m[k], span.nearest, span.farthest, RANGES)
        c = _part(places.bearing[k], span.port, span.starboard, BEARINGS)
        i, j = _cell(places.north[k]), _cell(places.east[k])
        in_fan = _pooled(spots[r, c], tracks[r, c], rings[r], POOLED_TRACKS)
        kept = _kept(world, i, j, images)
        here, all_here = kept * world.counts[SPOTS, i, j], kept * world.counts[TRACKS, i, j]
        share[k] = min(_pooled(here, all_here, in_fan, POOLED_TRACKS), MOST)
    return share
