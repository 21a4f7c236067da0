"""Grid of the water around the vehicle: the time until which each cell is known to be empty.

What was seen to be empty stays so until something could have moved in, by the shortest way from what was not seen.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Mask
from ods.compiled import native
from ods.messages import Sector
from ods.tracker.clearance.fan_mask import FanMask
from ods.tracker.clearance.volume_mask import LayerSeen, layer_seen
from ods.tracker.measurement.coverage.looked import ObservedRanges
from ods.tracker.settings import ClearanceSettings

REACH = 80
"""Cells from the vehicle's to the border."""
ROOM = 1.05
"""The grid's reach in sonar ranges; the grid is made again when the sonar's range has outgrown it,"""
SMALLEST = 0.4
"""or is less than this share of it."""
SIDE = 2 * REACH + 1
NEVER = -math.inf

Counts = NDArray[np.uint16]


class Head(NamedTuple):
    """The sonar's head."""

    place: Floats
    """(3,) NED, m."""
    turned: Floats
    """(3, 3) head to global."""


class FreeGrid:
    """Cells of `cell_m`, north and east, with the vehicle in the middle one. Times are s since any instant."""

    def __init__(self, range_m: float, settings: ClearanceSettings) -> None:
        self.cell_m = ROOM * range_m / REACH
        self._settings = settings
        self._free_until = np.full((SIDE, SIDE), NEVER)
        self._seen_s = np.full((SIDE, SIDE), NEVER)
        """When a mechanically scanned head saw each cell to be empty, until when nothing can be there from above or
        below since then,"""
        self._above_s = np.full((SIDE, SIDE), NEVER)
        self._looks_s: list[float] = []
        """and when it looked at its newest three parts."""
        self._middle: tuple[int, int] | None = None
        self._down = 0.0

    def fits(self, range_m: float) -> bool:
        """Return whether the grid is made for a sonar of this range."""
        return SMALLEST * REACH * self.cell_m <= range_m <= REACH * self.cell_m

    def free(self, t_s: float) -> Mask:
        """Return (SIDE, SIDE) which cells are known to be empty; rows north, columns east."""
        return np.asarray(self._free_until >= t_s)

    def move(self, place: Floats) -> None:
        """Let the vehicle be at `place`, (3,) NED. The layer that is looked at goes down and up with it.

        By as much as it does, what is above and below is nearer to the layer.
        """
        north, east = (math.floor(float(p) / self.cell_m) for p in place[:2])
        if self._middle is not None:
            self._scroll(north - self._middle[0], east - self._middle[1])
            sooner_s = abs(float(place[2]) - self._down) / self._settings.fastest_vertical_m_s
            if sooner_s:
                self._free_until -= sooner_s
                self._above_s -= sooner_s
        self._middle, self._down = (north, east), float(place[2])

    def _scroll(self, north: int, east: int) -> None:
        for axis, steps in enumerate((north, east)):
            if not steps:
                continue
            fresh = slice(max(0, SIDE - steps), SIDE) if steps > 0 else slice(0, min(SIDE, -steps))
            grids = self._free_until, self._seen_s, self._above_s
            self._free_until, self._seen_s, self._above_s = (np.roll(each, -steps, axis) for each in grids)
            for each in (self._free_until, self._seen_s, self._above_s):
                each[(slice(None),) * axis + (fresh,)] = NEVER

    def look(self, t_s: float, mask: FanMask, head: Head, *, swept: bool = False) -> None:
        """Update the grid by a ping at `t_s`.

        swept: of a mechanically scanned sonar, which shows its sector part after part. What comes into a part comes by
        way of water that is not known, or not any more: not of the part before it, as the head turned on from there
        faster than anything could follow it.
        """
        if self._middle is None:
            return
        cells = self._around(mask.sector, head)
        self._keep(t_s, cells, self._layer(cells, head).in_fan(mask, self._settings.half_height_m), swept=swept)

    def look_through(self, t_s: float, sector: Sector, looked: ObservedRanges, head: Head, turn_rad: float) -> None:
        """Take in what a range image at `t_s` showed; turn_rad: see `layer_seen`."""
        if self._middle is None:
            return
        cells = self._around(sector, head)
        places, half_m = self._layer(cells, head).in_head(), self._settings.half_height_m
        self._keep(t_s, cells, layer_seen(sector, looked, places, half_m, self.cell_m, turn_rad))

    def _keep(self, t_s: float, cells: tuple[slice, slice], seen: LayerSeen, *, swept: bool = False) -> None:
        empty, received, room = seen
        clear, since_s, above_s = empty & (room >= 0.0), t_s, t_s + room / self._settings.fastest_vertical_m_s
        if swept:
            clear, since_s, above_s = self._with_parts_before(t_s, cells, clear, received, above_s)
        away = cells_from_others(clear)
        cell_s = self.cell_m / self._settings.fastest_m_s
        native.hold_empty(self._free_until[cells], away, received, above_s, since_s, cell_s, NEVER)

    def _with_parts_before(
        self, t_s: float, place: tuple[slice, slice], clear: Mask, received: Mask, above_s: Floats
    ) -> tuple[Mask, float, Floats]:
        """Return which cells are known to be empty by all parts so far, since when at the least nothing but what is
        not known can have moved in, and until when nothing can have come from above or below."""
        if clear.any() or received.any():
            self._looks_s = [*self._looks_s, t_s][-3:]
        seen_s, until, vertical_s = (each[place] for each in (self._seen_s, self._free_until, self._above_s))
        seen_s[clear], seen_s[received] = t_s, NEVER
        vertical_s[clear] = above_s[clear]
        until[received] = NEVER
        since_s = self._looks_s[0] if len(self._looks_s) == 3 else NEVER
        newest = seen_s >= (self._looks_s[-2:] or [t_s])[0]
        return np.asarray((newest | (until >= t_s)) & (vertical_s >= t_s)), since_s, vertical_s

    def _around(self, sector: Sector, head: Head) -> tuple[slice, slice]:
        """Return the rows and columns that the fan is in."""
        assert self._middle is not None
        rim = sector.range_max_m * (_rim(sector.bearing_min_rad, sector.bearing_max_rad) @ head.turned[:2, :2].T)
        spans = []
        for middle, place, low, high in zip(self._middle, head.place, rim.min(axis=0), rim.max(axis=0), strict=False):
            first = math.floor((place + min(low, 0.0)) / self.cell_m) - 2 - middle + REACH
            end = math.ceil((place + max(high, 0.0)) / self.cell_m) + 3 - middle + REACH
            spans.append(slice(min(max(first, 0), SIDE), min(max(end, 0), SIDE)))
        return spans[0], spans[1]

    def _layer(self, cells: tuple[slice, slice], head: Head) -> "Layer":
        rows, columns = cells
        first = np.array(self._middle) - REACH + 0.5
        north_m = float((first[0] + rows.start) * self.cell_m - head.place[0])
        east_m = float((first[1] + columns.start) * self.cell_m - head.place[1])
        down_m = self._down - float(head.place[2])
        shape = rows.stop - rows.start, columns.stop - columns.start
        return Layer(shape, head.turned, north_m, east_m, down_m, self.cell_m)


class Layer(NamedTuple):
    """Middles of cells at the vehicle's depth, as seen from the head; north, east, down."""

    shape: tuple[int, int]
    turned: Floats
    """(3, 3) head to global."""
    north_m: float
    """Of the first cell,"""
    east_m: float
    down_m: float
    cell_m: float
    """and from one to the next."""

    def in_head(self) -> tuple[Floats, Floats, Floats]:
        """Return them forward, starboard and down of the head, m."""
        north = self.north_m + np.arange(self.shape[0]) * self.cell_m
        east = self.east_m + np.arange(self.shape[1]) * self.cell_m
        forward, starboard, down = (
            (axis[0] * north + axis[2] * self.down_m)[:, None] + (axis[1] * east)[None, :] for axis in self.turned.T
        )
        return forward, starboard, down

    def in_fan(self, mask: FanMask, half_height_m: float) -> LayerSeen:
        """Return what a ping showed of the layer of +- `half_height_m` there."""
        sector, (shape, *cells) = mask.sector, self
        seen = LayerSeen(np.zeros(shape, bool), np.zeros(shape, bool), np.empty(shape))
        borders = sector.bearing_min_rad, sector.bearing_max_rad, sector.range_min_m, sector.range_max_m
        vertical = math.sin(sector.half_vertical_rad), half_height_m
        native.layer_in_fan(mask.shown(), borders, vertical, tuple(cells), seen)
        return seen


@lru_cache(maxsize=4)
def _rim(first_rad: float, last_rad: float) -> Floats:
    """Return (33, 2) directions over a sector, forward and starboard. Do not write to it."""
    bearing = np.linspace(first_rad, last_rad, 33)
    return np.column_stack([np.cos(bearing), np.sin(bearing)])


def cells_from_others(mask: Mask) -> Counts:
    """Return by how many steps to a neighbour each cell is away from one that is not in the mask, or from the rim.

    The straight way is at least sqrt(1/2) of that.
    """
    away = np.empty(mask.shape, np.uint16)
    native.cells_from_others(mask, away)
    return away
