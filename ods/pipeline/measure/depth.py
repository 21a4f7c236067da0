"""Along the beams: where an echo begins and ends, and where in between the middle of its intensity lies.

The edges of each beam's part are those of a step, whatever the detector's levels are (edge.py). A point lies at its
crest.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import FanTable
from ods.pipeline.image.regions import Runs
from ods.pipeline.measure.edge import outermost_crest

_FRINGE = 0.3
"""Runs whose first crest is lower than this share of the highest one are a fringe, in which speckle joins in."""
_SHORT, _LONGER = 1.15, 1.4
"""Widths of a point, up to which a crest is one, and from which on it is none."""
_PALES = 0.21
"""Width of a point, by which the slope of a front that pales lies before it."""
_LEVEL = 0.41
"""Where in its depth the middle of an echo's intensity lies at least, if it may go on behind: a front pales."""
_WEAK = 3.5
"""An echo of which the mean level is less than this, in multiples of the background, may be a fragment of its body,"""
_GOES_ON = 0.18
"""that goes on beyond it as long as the level is this share of the echo's over the background."""
_SURE, _LOST = 2.0, 6.0
"""Sums of levels over that, in multiples of the background, with which it does, and at which the search ends."""


class Ends(NamedTuple):
    """Where runs begin and end, with sub-cell accuracy."""

    near_m: Floats
    """(runs,) slant range."""
    far_m: Floats
    width_m: Floats
    """Of the first crest."""
    height: Floats
    """Of the first crest, over the background and in multiples of it."""


class Level(NamedTuple):
    """Levels of an image and of an echo."""

    background: float
    mean: float
    """Of the echo, in multiples of the background."""
    point: float
    """Width of a point, columns."""


class Depth(NamedTuple):
    """An echo along the line of sight."""

    near_m: float
    """Slant range of its nearest point."""
    far_m: float
    middle: float
    """Of its intensity: 0 at the near edge, 1 at the far one."""
    height: float
    """Of its nearest part's first crest, over the background and in multiples of it,"""
    width: float
    """and its width, in widths of a point,"""
    point_m: float
    """which is this wide."""


@kernel
def ends_of(image: Image, runs: Runs, level: Level, fan: FanTable) -> Ends:
    """Return where each run begins and ends."""
    count = runs.shape[0]
    ends = Ends(np.empty(count), np.empty(count), np.empty(count), np.empty(count))
    for i in range(count):
        run = runs[i]
        row, reach = image[run.beam], (run.first, run.stop)
        crest = outermost_crest(row, reach, False, level.background, level.point)
        last = outermost_crest(row, reach, True, level.background, level.point)
        ends.near_m[i], ends.height[i] = fan.range0_m + crest.edge * fan.dr_m, crest.height
        ends.far_m[i] = max(fan.range0_m + last.edge * fan.dr_m, ends.near_m[i])
        ends.width_m[i] = crest.width * fan.dr_m
    return ends


@kernel
def depth_of(image: Image, runs: Runs, ends: Ends, level: Level, fan: FanTable) -> Depth:
    """Return the depth of the echo of these runs, of which `ends` tells the ends."""
    background, mean, point_m = level.background, level.mean, level.point * fan.dr_m
    nearest, far = _nearest_and_far(ends, point_m)
    near = ends.near_m[nearest] + _behind_the_slope(ends.width_m[nearest], point_m)
    far = max(far, near + 0.5 * fan.dr_m)
    middle = _middle(image, runs, background, fan)
    if mean < _WEAK:
        least = background * (1.0 + _GOES_ON * (mean - 1.0))
        first, stop = runs[0].first, runs[0].stop
        for i in range(runs.shape[0]):
            first, stop = min(first, runs[i].first), max(stop, runs[i].stop)
        beams = image[runs[0].beam : runs[-1].beam + 1]
        before = _goes_on(beams[:, :first][:, ::-1], background, least) * fan.dr_m
        if before > 0.0 or middle - near > _LEVEL * (far - near):
            far += _goes_on(beams[:, stop:], background, least) * fan.dr_m
        if before > 0.0:
            near = min(near, fan.range0_m + (first - 0.5) * fan.dr_m - before)
    width = ends.width_m[nearest] / point_m
    return Depth(near, far, (middle - near) / (far - near), ends.height[nearest], width, point_m)


@kernel
def _nearest_and_far(ends: Ends, point_m: float) -> tuple[int, float]:
    """Return the number of the nearest run, and where the farthest one ends, of those that are not a fringe.

    Of many runs one is too near by chance, a faint one most: each counts as later by what its speckle does to it.
    """
    height = 0.0
    for i in range(ends.height.size):
        height = max(height, ends.height[i])
    nearest, far, least = 0, 0.0, np.inf
    for i in range(ends.height.size):
        if ends.height[i] >= _FRINGE * height:
            far = max(far, ends.far_m[i])
            near = ends.near_m[i] + point_m / ends.height[i]
            if near < least:
                nearest, least = i, near
    return nearest, far


@kernel
def _behind_the_slope(width_m: float, point_m: float) -> float:
    """Return how far behind the place of a step with such a slope the object begins, m.

    A point lies at the crest, half its width behind; a front that pales rises to its highest level at once.
    """
    wide = width_m / point_m
    pulse = min(max((_LONGER - wide) / (_LONGER - _SHORT), 0.0), 1.0)
    pales = _PALES * min(max((5.0 - wide) / 3.0, 0.0), 1.0)
    return (pulse * 0.5 + (1.0 - pulse) * pales) * point_m


@kernel
def _middle(image: Image, runs: Runs, background: float, fan: FanTable) -> float:
    """Return the mean range of the echo's cells, weighted by their intensity over the background's."""
    total, moment = 0.0, 0.0
    for i in range(runs.shape[0]):
        run = runs[i]
        row = image[run.beam, run.first : run.stop]
        for j in range(row.size):
            weight = max(row[j] * row[j] - background * background, 0.0)
            total += weight
            moment += weight * (run.first + j)
    return fan.range0_m + moment / max(total, 1e-30) * fan.dr_m


@kernel
def _goes_on(beams: Image, background: float, least: float) -> int:
    """Return how many columns further a body reaches whose level is at least `least`, by the sum of what is over it.

    beams: (beams of the echo, columns beyond it), outwards.
    """
    total, best, columns = 0.0, _SURE * background, 0
    for j in range(beams.shape[1]):
        for b in range(beams.shape[0]):
            total += beams[b, j] - least
        if total > best:
            best, columns = total, j + 1
        if total < best - _LOST * background:
            break
    return columns
