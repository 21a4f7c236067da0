"""The grid and the bodies by bearing sector, as the vehicle sees them."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints32, Mask
from ods.compiled import native
from ods.tracker.clearance.free_grid import REACH, SIDE

BLUR = math.sqrt(2.0)
"""Largest distance of a point in a cell from its middle, cells, seen from a vehicle anywhere in its own."""


SHORTEST = 3
"""Rings."""


class OccupiedSectors(NamedTuple):
    """(m,) each, of what is known to be there."""

    azimuth: Floats
    """rad, from north to east."""
    half_width: Floats
    """rad."""
    distance_m: Floats
    """To the near edge; 0: the vehicle may be inside."""
    sigma_m: Floats


class Clear(NamedTuple):
    """(n,) each, by sector."""

    from_m: Floats
    to_m: Floats
    """0: nothing is known to be empty."""


class _Bins(NamedTuple):
    """Which cells belong to which sector and ring: pairs of a cell and a bin."""

    cell: Ints32
    bin: Ints32


def clear_water(free: Mask, cell_m: float, sectors: int) -> Clear:
    """Return the first stretch of each sector in which all cells are `free`, (SIDE, SIDE).

    It begins where SHORTEST rings are: fewer are less than what the cells blur.
    """
    rings = np.empty((sectors, 2), np.int64)
    native.clear_rings(free.ravel(), _bins(sectors), REACH, SHORTEST, rings)
    first, last = rings.T
    from_m = np.where(first > 0, first + BLUR, 0.0) * cell_m
    to_m = (last - BLUR) * cell_m
    nothing = to_m <= from_m
    return Clear(np.where(nothing, 0.0, from_m), np.where(nothing, 0.0, to_m))


def nearest_edge(bodies: OccupiedSectors, sectors: int, sigmas: float = 0.0) -> Floats:
    """Return (n,) distances to the nearest edge in each sector, less a number of standard deviations, 0 at least.

    Infinite where there is none.
    """
    nearest = np.empty(sectors)
    native.nearest_edge(bodies, sigmas, nearest)
    return nearest


@lru_cache(maxsize=4)
def _bins(sectors: int) -> _Bins:
    """Return the bins of all cells of the grid: a cell is in each sector that it may reach into."""
    north, east = (np.indices((SIDE, SIDE)) - REACH).reshape(2, -1)
    away, azimuth = np.hypot(north, east), np.arctan2(east, north)
    ring = away.astype(np.intp)
    inside = ring < REACH
    cell = np.flatnonzero(inside)
    away, azimuth, ring = away[inside], azimuth[inside], ring[inside]
    half = np.where(away > BLUR, np.arcsin(np.minimum(BLUR / np.maximum(away, BLUR), 1.0)), math.pi)
    width = 2.0 * math.pi / sectors
    low, high = np.floor((azimuth - half) / width).astype(int), np.floor((azimuth + half) / width).astype(int)
    cells, bins = [], []
    for step in range(sectors):
        reached = low + step <= high
        cells.append(cell[reached])
        bins.append((low + step)[reached] % sectors * REACH + ring[reached])
    return _Bins(np.concatenate(cells).astype(np.int32), np.concatenate(bins).astype(np.int32))
