"""Along the beams: where an echo begins and ends, and whether it is of a whole body or of its front.

An edge lies where the echo has half the level of its outermost crest: a symmetric filter leaves that point of a step in
place, whatever the threshold. An echo as short as the filter's response is that of a point, which lies at the crest.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import FanTable
from ods.pipeline.image.regions import Run, Runs

_FRONT, _BODY = 0.41, 0.47
"""Where in its depth the middle of an echo's intensity lies: a sphere's front pales behind its crest [SSIE eq. 3], a
body that shines all over stays level."""
_TOP, _BEFORE_TOP = 0.97, 0.79
"""Share of the level where the crest of a step begins, and of the rise from half of it where a Gaussian gets there."""
_WEAK = 3.5
"""An echo of which the mean level is less than this, in multiples of the background, may be a fragment of its body,"""
_FADES, _HIDDEN_M = 2.35, 0.3
"""and below this there is a standard deviation of how much nearer its body begins."""
_GOES_ON = 0.25
"""A body goes on beyond the echo found as long as the level is this share of the echo's over the background."""
_SURE, _LOST = 2.0, 6.0
"""Sums of levels over that, in multiples of the background, with which it does, and at which the search ends."""


class Ends(NamedTuple):
    """Where runs begin and end, with sub-cell accuracy."""

    near_m: Floats
    """(runs,) slant range."""
    far_m: Floats


class Level(NamedTuple):
    """Levels of an image and of an echo."""

    background: float
    mean: float
    """Of the echo, in multiples of the background."""


class Depth(NamedTuple):
    """An echo along the line of sight."""

    near_m: float
    """Slant range of its nearest point."""
    far_m: float
    rise_m: float
    """From half the level of its first crest to the crest."""
    middle: float
    """Where in its depth, from 0 to 1, the middle of its intensity lies, as it was detected."""
    whole: float
    """1: the echo is of a whole body; 0: it pales behind its front."""
    hidden_m: float
    """Standard deviation of how much nearer the body of a fragment begins; 0 of what is none."""


@kernel
def ends_of(image: Image, runs: Runs, fan: FanTable) -> Ends:
    """Return where each run begins and ends."""
    near, far = np.empty(runs.shape[0]), np.empty(runs.shape[0])
    for i in range(runs.shape[0]):
        run = runs[i]
        row = image[run.beam, run.first : run.stop]
        near[i] = fan.range0_m + (run.first + _edge(row, False) - 0.5) * fan.dr_m
        far[i] = fan.range0_m + (run.stop - _edge(row, True) - 0.5) * fan.dr_m
    return Ends(near, far)


@kernel
def depth_of(image: Image, runs: Runs, ends: Ends, level: Level, fan: FanTable) -> Depth:
    """Return the depth of the echo of these runs, of which `ends` tells the ends."""
    background, mean = level
    nearest, far = 0, ends.far_m[0]
    for i in range(runs.shape[0]):
        if ends.near_m[i] < ends.near_m[nearest]:
            nearest = i
        far = max(far, ends.far_m[i])
    near = ends.near_m[nearest]
    rise = _rise(image, runs[nearest], fan, near)
    near += rise * min(1.0, (2.0 * rise / max(far - near, fan.dr_m)) ** 2)
    far = max(far, near + 0.5 * fan.dr_m)
    middle = (_middle(image, runs, background, fan) - near) / (far - near)
    whole = min(max((middle - _FRONT) / (_BODY - _FRONT), 0.0), 1.0)
    hidden = _HIDDEN_M * whole * min(max((_FADES - mean) / 0.4, 0.0), 1.0)
    if mean < _WEAK:
        least = background * (1.0 + _GOES_ON * (mean - 1.0))
        first, stop = runs[0].first, runs[0].stop
        for i in range(runs.shape[0]):
            first, stop = min(first, runs[i].first), max(stop, runs[i].stop)
        beams = image[runs[0].beam : runs[-1].beam + 1]
        near -= _goes_on(beams[:, :first][:, ::-1], background, least) * fan.dr_m
        if whole > 0.0:  # a fragment deep inside a body looks like a front; how deep the body is, it does not tell
            far += _goes_on(beams[:, stop:], background, least) * fan.dr_m
    return Depth(near, far, rise, middle, whole, hidden)


@kernel
def _first_crest(row: Floats32, backwards: bool) -> int:
    """Return how many cells before the first crest are, seen from one end of a run."""
    last = row.size - 1
    step = -1 if backwards else 1
    begin = last if backwards else 0
    crest = 0
    while crest < last and row[begin + step * (crest + 1)] > row[begin + step * crest]:
        crest += 1
    return crest


@kernel
def _rise(image: Image, run: Run, fan: FanTable, near: float) -> float:
    """Return how far the first crest of a run lies behind `near`, where it has half of its level, m.

    Not farther than it is wide: what rises longer than the filter's response does is speckle on a body.
    """
    row = image[run.beam]
    crest = run.first + _first_crest(row[run.first : run.stop], False)
    rise = min(fan.range0_m + crest * fan.dr_m - near, _half_width(row, crest) * fan.dr_m)
    top = np.float32(_TOP) * row[crest]
    while crest > run.first and row[crest - 1] >= top:
        crest -= 1
    rise = min(rise, (fan.range0_m + crest * fan.dr_m - near) / _BEFORE_TOP)
    return float(max(rise, 0.5 * fan.dr_m))


@kernel
def _half_width(row: Floats32, crest: int) -> float:
    """Return half the width, cells, of a crest of Gaussian shape as sharp as this one, at half its level."""
    if crest == 0 or crest + 1 == row.size:
        return 1.0
    sharpness = 2.0 * row[crest] - row[crest - 1] - row[crest + 1]
    return float(np.sqrt(2.0 * np.log(2.0) * row[crest] / max(sharpness, 1e-3 * row[crest])))


@kernel
def _edge(row: Floats32, backwards: bool) -> int:
    """Return how many cells lie outside the point of half the level of the first crest, seen from one end of a run."""
    last = row.size - 1
    step = -1 if backwards else 1
    begin = last if backwards else 0
    crest = _first_crest(row, backwards)
    half = np.float32(0.5) * row[begin + step * crest]
    outside = 0
    while outside < crest and row[begin + step * outside] < half:
        outside += 1
    return min(outside, last // 2)


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
