"""Where echoes come and go: places that show an echo now and then, as a sea-bed does, without an object.

A false alarm of noise is gone in the next image. An echo of a rough sea-bed comes back to its place in one image of
two or three, which chance does not explain any more than it explains an object: such a place is a spot. How many of the
echoes of nothing are of spots is counted, by place in the fan and in the world, from the tracks that ended as no
objects: what came of them tells how likely each was one (`existence`). An object that is there teaches nothing: its
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


class _Span(NamedTuple):
    nearest: float
    farthest: float
    port: float
    starboard: float


class Flicker:
    """Tracks that ended as no objects, and how many of them were of spots."""

    def __init__(self) -> None:
        self._fan = np.zeros((2, RANGES, BEARINGS))
        self._world = np.zeros((2, CELLS, CELLS), np.float32)

    def state(self) -> FlickerState:
        """Return what was counted."""
        cells = np.flatnonzero(self._world[TRACKS]).astype(np.int32)
        return FlickerState(self._fan.tobytes(), cells.tobytes(), self._world.reshape(2, -1)[:, cells].tobytes())

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
        self._world = np.zeros((2, CELLS, CELLS), np.float32)
        self._world.reshape(2, -1)[:, cells] = counts

    def learn(self, ended: Places, spots: Floats, tracks: Floats, sector: Sector) -> None:
        """Take in the tracks that an image ended: (k,) probabilities of spots, and of no objects.

        Called for every image.
        """
        _learn(self._fan, self._world, ended, np.array([np.minimum(spots, tracks), tracks]), _span_of(sector))

    def share(self, places: Places, sector: Sector, per_scan: float) -> Floats:
        """Return (n,) the share of spots among echoes of nothing at each place.

        per_scan: echoes of nothing in an image that tell their strength.
        """
        prior = CALM + NEW * per_scan**2 / (per_scan**2 + MANY**2)
        return _share(self._fan, self._world, places, _span_of(sector), prior)


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
            kept = WORLD_MEMORY if world[TRACKS, i, j] > LEAST_TRACKS else 0.0
            world[SPOTS, i, j] *= kept
            world[TRACKS, i, j] *= kept
    for k in range(counts.shape[1]):
        ring = _part(ended.range_m[k], span.nearest, span.farthest, RANGES)
        column = _part(ended.bearing[k], span.port, span.starboard, BEARINGS)
        i, j = _cell(ended.north[k]), _cell(ended.east[k])
        for row in range(2):
            fan[row, ring, column] += counts[row, k]
            world[row, i, j] += counts[row, k]


@kernel
def _pooled(spots: float, tracks: float, larger: float, weight: float) -> float:
    """Return the share in a part, of its own counts and of that in the larger part."""
    return (spots + weight * larger) / (tracks + weight)


@kernel
def _share(fan: Floats, world: Floats32, places: Places, span: _Span, prior: float) -> Floats:
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
        share[k] = min(_pooled(world[SPOTS, i, j], world[TRACKS, i, j], in_fan, POOLED_TRACKS), MOST)
    return share
