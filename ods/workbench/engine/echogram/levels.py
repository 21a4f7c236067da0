"""An echogram: the levels of a whole mission, range against ping, the highest of what shares a cell."""

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats, Floats32, Mask
from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.messages import Ping, frame_of, seen_from_above
from ods.plots.polar import decibels
from ods.workbench.engine.data import Data

MOST_COLUMNS, MOST_CELLS = 2048, 1024
"""Of an echogram, however long the mission is: 8 MB."""
SHOW_S = 0.5
"""Between two looks at one that is being read."""
SAMPLED_CELLS = 60_000
"""Number of cells from which the median is taken."""


@dataclass(frozen=True, eq=False)
class Echogram:
    """Levels of `pings` pings. Not to be changed any more."""

    level_db: Floats32
    """(columns, cells) the highest level of `per_column` pings in a cell, dB over the median; NaN: no sample."""
    pings: int
    per_column: int
    cell_m: float
    """Cell k spans the slant ranges from k to k + 1 times this."""
    read: int
    """Pings that were read until now."""
    bearing_rad: Floats
    """(beams,) of the first ping."""
    t_s: Floats
    """(columns,) since the first ping; NaN: not read yet."""

    @property
    def half_beam_rad(self) -> float:
        """Half the widest step from a beam to the next."""
        return float(0.5 * np.diff(self.bearing_rad).max(initial=0.0))


def title_of(echogram: Echogram, beam: int | None) -> str:
    """Return what an echogram of a beam, or of all, is called."""
    which = "the highest level of all beams"
    if beam is not None:
        known = beam < len(echogram.bearing_rad)
        which = f"beam {beam}" + (f" at {np.degrees(echogram.bearing_rad[beam]):+.1f}°" if known else ": there is none")
    shared = f", {echogram.per_column} pings per column: the highest" if echogram.per_column > 1 else ""
    return f"Echogram of {echogram.pings} pings{shared}: {which}"


def read_echogram(
    data: Data, beam: int | None = None, report: Callable[[Echogram], bool] = lambda _: True
) -> Echogram | None:
    """Return the echogram of one beam, or of the highest level over all beams; None: given up. It reads all pings,
    which lasts: not for the page's process.

    report: gets what there is until now, from time to time; returns whether to go on.
    """
    filling = Filling(len(data.pings), beam)
    shown_s = time.monotonic()
    for place in range(len(data.pings)):
        with contextlib.suppress(OdsError):  # one that cannot be read is an empty column
            filling.add(place, data.pings[place])
        if time.monotonic() - shown_s > SHOW_S:
            if not report(filling.result()):
                return None
            shown_s = time.monotonic()
    return filling.result()


class Filling:
    """An echogram in the making. Its memory is bounded: many pings share a column, many samples a cell."""

    def __init__(
        self, pings: int, beam: int | None = None, most_columns: int = MOST_COLUMNS, most_cells: int = MOST_CELLS
    ) -> None:
        """most_cells: an even number."""
        self._pings, self._beam = pings, beam
        self._per_column = max(1, -(-pings // most_columns))
        self._levels = np.full((-(-pings // self._per_column), most_cells), np.nan, np.float32)
        self._cell_m = 0.0
        self._far_m = 0.0
        self._read, self._first_ns = 0, 0
        self._bearing: Floats = np.zeros(0)
        self._t_ns = np.zeros(len(self._levels), np.int64)

    def add(self, place: int, ping: Ping) -> None:
        """Take in a ping; a range image from above. Its column and its cells keep the highest level that came."""
        ping = seen_from_above(ping)
        if not self._read:
            self._first_ns = ping.t_ns
            self._bearing = np.array(ping.bearing_rad[: ping.beams // ping.planes])
        self._make_room(ping)
        at = place // self._per_column
        column = self._levels[at]
        self._t_ns[at] = self._t_ns[at] or ping.t_ns
        levels = levels_along(ping, self._beam)
        np.fmax(column, by_cells(levels, ping.range0_m, ping.dr_m, self._cell_m, len(column)), out=column)
        self._read += 1

    def result(self) -> Echogram:
        """Return what there is until now."""
        used = max(1, round(np.ceil(self._far_m / self._cell_m - 1e-9))) if self._read else 1
        levels = self._levels[:, :used].copy()
        levels -= _median(levels)
        t_s = np.where(self._t_ns > 0, (self._t_ns - self._first_ns) / NS, np.nan)
        return Echogram(levels, self._pings, self._per_column, self._cell_m or 1.0, self._read, self._bearing, t_s)

    def _make_room(self, ping: Ping) -> None:
        """Lengthen cells until the ping's farthest sample has one."""
        far_m = ping.range0_m + (ping.samples - 0.5) * ping.dr_m
        cells = self._levels.shape[1]
        self._far_m = max(self._far_m, far_m)
        if not self._cell_m:
            self._cell_m = max(ping.dr_m, far_m / cells)
        while self._far_m > cells * self._cell_m * (1.0 + 1e-9):
            half = np.fmax(self._levels[:, ::2], self._levels[:, 1::2])
            self._levels[:, : cells // 2], self._levels[:, cells // 2 :] = half, np.nan
            self._cell_m *= 2.0


def levels_along(ping: Ping, beam: int | None) -> Floats32:
    """Return the (samples,) recorded levels of a beam, dB, or the highest over all beams, and over all planes.

    NaN where there is none: no such beam, or samples without data. Raises ValueError when the buffer does not fit.
    """
    beams = ping.beams // ping.planes
    rows = slice(None) if beam is None else slice(beam, ping.beams if beam < beams else beam, beams)
    samples = frame_of(ping)[rows]
    if not len(samples):
        return np.full(ping.samples, np.nan, np.float32)
    if not ping.no_data:
        return decibels(samples.max(axis=0), ping)
    known = _known(ping)[rows]
    return np.where(known.any(axis=0), decibels(np.where(known, samples, 0).max(axis=0), ping), np.float32(np.nan))


def _known(ping: Ping) -> Mask:
    """Return (beams, samples): where there are data."""
    known = np.ones((ping.beams, ping.samples), np.bool_)
    for beam, first, stop in ping.no_data:
        known[beam, first:stop] = False
    return known


def by_cells(levels: Floats32, range0_m: float, dr_m: float, cell_m: float, cells: int) -> Floats32:
    """Return the highest of the levels (samples,) that lie in each of the cells from range 0 on, (cells,): NaN where
    there are none. Where samples are farther apart than cells, each fills all that it stands for."""
    found = np.full(cells, np.nan, np.float32)
    begin_m = range0_m - 0.5 * dr_m
    first = min(max(0, int(np.floor(begin_m / cell_m + 1e-9))), cells)
    stop = min(cells, int(np.ceil((begin_m + len(levels) * dr_m) / cell_m - 1e-9)))
    if stop > first:
        edges_m = cell_m * np.arange(first, stop)
        begins = np.clip(np.floor((edges_m - begin_m) / dr_m + 1e-9).astype(np.int64), 0, len(levels) - 1)
        found[first:stop] = np.fmax.reduceat(levels, begins)
    return found


def _median(levels: Floats32) -> float:
    step = max(1, levels.size // SAMPLED_CELLS)
    some = levels.ravel()[:: step | 1]
    some = some[np.isfinite(some)]
    return float(np.median(some)) if some.size else 0.0
