"""Where the bottom's echo sets in: its range tells how high the sonar is, where no altimeter does.

A fan that looks ahead meets a bottom below it with the lower side of its main lobe first. Over the range, the level
rises there from what the pattern's skirt hears to the bottom's own, and stays: by which it is told from an echo of a
body, of a wall, of fish. Side lobes hear the bottom before, and between them and the main lobe is a dip: by which it is
told from the side lobes of a bottom too deep for the main lobe, and from waves above. The range of the rise depends on
the height and on where the fan looks; the latter the tracker knows from the pose. Several groups of beams are looked at
by themselves: a roll, a slope and a body move them apart.

Levels are compared over ratios of ranges, as a flat bottom at any height gives the same profile over log range. All
windows and limits below were set on the beds of config/scenes/sea (`python -m benchmarks.bottom_echo`).
"""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats, Ints, Mask
from ods.compiled.kernel import kernel
from ods.messages import BottomEcho, Ping
from ods.pipeline.image.amplitude import SampleScale

EVERY = 4
"""Looked for at each so many-th ping: heights change slowly."""
GROUPS = 10
"""Groups of neighbouring beams, of which"""
FEWEST = 3
"""so many, and half of them at least, must show it."""
RATIO = 1.04
"""Of the ranges of neighbouring bins."""
NEAREST_M = 1.0
LEAST_SAMPLES = 20
"""The first bin lies beyond so many samples."""
LEAST_COUNT = 1.0
"""Counts whose mean is lower do not tell how quiet it was."""
QUIET_FROM, QUIET_TO = -15, -5
"""Bins, from the middle of the rise, of the quiet before it,"""
LOUD_FROM, LOUD_TO = 4, 13
"""and of the bottom behind it,"""
PART, FEWEST_LOUD = 3, 5
"""of which each so many may be"""
UNEVEN_DB = 5.0
"""off their mean by no more; where the image ends, so few do."""
RISE_DB = 10.0
"""The bottom is louder than the quiet before it by so much at least."""
LOUDER_DB = 6.0
"""What is louder than that behind it was no main lobe's."""
EDGE_DB, EDGE_OF_HALF = 4.0, 1.15
"""So much under the level behind the rise the fan hears at so many times its half opening (-6 dB, both ways): at 1.08
with the pattern of [SSIE] figure 8, at 1.3 with that of an evenly lit aperture. So the first is told 7 % too deep."""
SEARCHED = 14
"""Bins in which that level is looked for."""
TURNS = 3
DIP_FROM, DIP_TO = -24, -3
"""Bins, from the rise, in which the dip is looked for,"""
HUMP_FROM, HUMP_TO = -43, -12
"""and what side lobes hear before it, louder by"""
DIP_DB = 1.0
"""so much. Nearer to the rise it may be the echo from straight below, and the rise that of a side lobe."""
SMOOTH = 4
"""A level is that of so many bins on either side, too."""


class LookedAt(NamedTuple):
    """Which samples are looked at."""

    borders: Ints
    """(groups + 1,) first beam of each group, and the end."""
    columns: Ints
    """(2, bins) samples, a quarter into each bin and a quarter before its end."""


class BottomEchoFinder:
    """Finds it in the lowest plane of pings of one geometry."""

    def __init__(self, ping: Ping, first: int, half_vertical_rad: float) -> None:
        """`first`: samples that are none; `half_vertical_rad`: half the vertical opening of a plane."""
        per_plane = ping.beams // ping.planes
        elevation = np.array(ping.elevation_rad or [0.0] * ping.beams).reshape(ping.planes, per_plane).mean(axis=1)
        start = int(elevation.argmin()) * per_plane
        groups = min(GROUPS, per_plane)
        borders = start + np.arange(groups + 1) * per_plane // groups
        self._bearing = [float(np.mean(ping.bearing_rad[begin:end])) for begin, end in pairwise(borders.tolist())]
        self._below_rad = EDGE_OF_HALF * half_vertical_rad - float(elevation.min())
        self._nearest_m = max(NEAREST_M, LEAST_SAMPLES * ping.dr_m, ping.range0_m + first * ping.dr_m)
        farthest = ping.range0_m + (ping.samples - 0.5) * ping.dr_m
        bins = math.floor(math.log(max(farthest / self._nearest_m, 1.0)) / math.log(RATIO))
        edges_m = self._nearest_m * RATIO ** np.arange(bins + 1)
        edges = np.ceil((edges_m - ping.range0_m) / ping.dr_m)
        columns = edges[:-1] + np.outer([0.25, 0.75], np.diff(edges))
        self._looked_at = LookedAt(borders.astype(np.intp), columns.astype(np.intp))

    def find(self, frame: AnyArray, missing: Mask, scale: SampleScale) -> BottomEcho | None:
        """Return where the bottom's echo sets in, None where there is none to be seen.

        frame: (beams, samples) as recorded; missing: those that hold no data, or `ALL_DATA`.
        """
        least = LEAST_COUNT if frame.dtype.kind == "u" else -math.inf
        db = {"linear": 0.0, "db": scale.factor, "log8": 20.0 / scale.factor}[scale.scale]
        place = _places(frame, missing, self._looked_at, db, least)
        seen = np.flatnonzero(place >= 0.0)
        if len(seen) < max(FEWEST, 0.5 * len(place)):
            return None
        ranges = self._nearest_m * RATIO ** (place[seen] + 0.5)
        return BottomEcho([self._bearing[group] for group in seen], ranges.tolist(), self._below_rad)


@kernel
def _places(frame: AnyArray, missing: Mask, looked_at: LookedAt, db: float, least: float) -> Floats:
    """Return (groups,) where the bottom's echo sets in; arguments as of `_levels`, result as of `_onsets`."""
    return _onsets(_levels(frame, missing, looked_at, db, least))


@kernel
def _levels(frame: AnyArray, missing: Mask, looked_at: LookedAt, db: float, least: float) -> Floats:
    """Return the level, dB, of the mean recorded number, (groups, bins); NaN where it is not known.

    db: of a unit, 0: numbers are linear; least: means below are not known.
    """
    groups, bins = len(looked_at.borders) - 1, looked_at.columns.shape[1]
    level = np.empty((groups, bins))
    total, count = np.empty(bins), np.empty(bins)
    for g in range(groups):
        total[:], count[:] = 0.0, 0.0
        for b in range(looked_at.borders[g], looked_at.borders[g + 1]):
            _add_beam(b, frame[b], missing, looked_at.columns, total, count)
        for k in range(bins):
            mean = total[k] / count[k]
            known = mean >= least and (mean > 0.0 or db > 0.0)
            level[g, k] = np.nan if not known else db * mean if db > 0.0 else 20.0 * math.log10(mean)
    return level


@kernel
def _add_beam(b: int, row: AnyArray, missing: Mask, columns: Ints, total: Floats, count: Floats) -> None:
    """Add what is looked at of beam b to the sums of the bins."""
    for k in range(len(total)):
        if missing.size == 0:
            total[k] += np.float64(row[columns[0, k]]) + np.float64(row[columns[1, k]])
            count[k] += 2.0
            continue
        for i in range(2):
            if not missing[b, columns[i, k]]:
                total[k] += row[columns[i, k]]
                count[k] += 1.0


@kernel
def _onsets(level: Floats) -> Floats:
    """Return (groups,) the place, in bins, where the bottom's echo sets in; -1 where it is not seen."""
    place = np.full(len(level), -1.0)
    for g in range(len(level)):
        middle = _strongest_rise(level[g])
        if middle >= 0:
            place[g] = _edge(level[g], middle)
    if not _dips(level, place):
        place[:] = -1.0
    return place


@kernel
def _dips(level: Floats, place: Floats) -> bool:
    """Tell whether the groups, on average, hear less shortly before the rise than farther before it."""
    low, dip = math.inf, 0
    for offset in range(DIP_FROM, DIP_TO):
        here = _before(level, place, offset)
        if here < low:
            low, dip = here, offset
    hump = -math.inf
    for offset in range(HUMP_FROM, min(dip, HUMP_TO)):
        hump = max(hump, _before(level, place, offset))
    return hump >= low + DIP_DB


@kernel
def _before(level: Floats, place: Floats, offset: int) -> float:
    """Return the mean level about a bin counted from each group's rise; NaN where there is none."""
    total, count = 0.0, 0
    for g in range(len(level)):
        first = round(place[g]) + offset - SMOOTH
        if place[g] >= 0.0 and first >= 0:
            for k in range(first, first + 2 * SMOOTH + 1):
                if not math.isnan(level[g, k]):
                    total += level[g, k]
                    count += 1
    return total / count if count > 0 else math.nan


@kernel
def _strongest_rise(level: Floats) -> int:
    """Return the bin in its middle, -1 where it is too weak."""
    best, rise = -1, RISE_DB
    for k in range(-QUIET_FROM, len(level) - LOUD_FROM - FEWEST_LOUD + 1):
        step = level[k + LOUD_FROM : k + LOUD_TO].mean() - level[k + QUIET_FROM : k + QUIET_TO].mean()
        if step > rise:
            best, rise = k, step
    return best


@kernel
def _edge(level: Floats, middle: int) -> float:
    """Return the place, in bins, where a rise comes to EDGE_DB under the level behind it, -1 where that does not stay.

    What is behind begins where that is, so both are found in turns.
    """
    place = float(middle)
    for _ in range(TURNS):
        k = round(place)
        if k + LOUD_FROM + FEWEST_LOUD > len(level):
            return -1.0
        loud = level[k + LOUD_FROM : k + LOUD_TO].mean()
        place = _down_to(level, k + LOUD_FROM, loud - EDGE_DB)
        if place < 0.0:
            return -1.0
    return place if _stays(level, round(place)) else -1.0


@kernel
def _down_to(level: Floats, start: int, wanted: float) -> float:
    """Return the first place before bin `start` where the level, over three bins, is `wanted`; -1: too far away."""
    above = math.nan
    for k in range(start, max(start - SEARCHED, 0), -1):
        here = level[k - 1 : k + 2].mean()
        if here < wanted:
            return k + (wanted - here) / (above - here) if above > here else float(k)
        above = here
    return -1.0


@kernel
def _stays(level: Floats, k: int) -> bool:
    """Tell whether the level behind a rise at bin k is even, and nothing behind it is much louder."""
    end = min(k + LOUD_TO, len(level))
    if end < k + LOUD_FROM + FEWEST_LOUD:
        return False
    loud = level[k + LOUD_FROM : end].mean()
    for begin in range(k + LOUD_FROM, end, PART):
        if not abs(level[begin : min(begin + PART, end)].mean() - loud) <= UNEVEN_DB:
            return False
    for begin in range(k + LOUD_TO, len(level) + LOUD_FROM - LOUD_TO + 1):
        if level[begin : begin + LOUD_TO - LOUD_FROM].mean() > loud + LOUDER_DB:
            return False
    return True
