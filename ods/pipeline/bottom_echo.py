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

from ods.base.arrays import AnyArray, Ints, Mask
from ods.compiled import native
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
EDGE_OF_HALF = 1.15
"""At so many times its half opening (-6 dB, both ways) the fan hears the bottom EDGE_DB (bottom_echo.c) weaker than
behind the rise: at 1.08 with the pattern of [SSIE] figure 8, at 1.3 with that of an evenly lit aperture. So the first
is told 7 % too deep."""


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
        place = np.empty(len(self._bearing))
        native.bottom_places(frame, missing, self._looked_at, db, least, place)
        seen = np.flatnonzero(place >= 0.0)
        if len(seen) < max(FEWEST, 0.5 * len(place)):
            return None
        ranges = self._nearest_m * RATIO ** (place[seen] + 0.5)
        return BottomEcho([self._bearing[group] for group in seen], ranges.tolist(), self._below_rad)
