"""The ends of echoes along a beam, with sub-cell accuracy, whatever the detector's levels are.

A step comes through a symmetric filter as a slope that has half the step's height where the step is. Near its foot the
slope is seen with less speckle, so the edge is read off there and moved by what a Gaussian slope is off.
"""

from typing import NamedTuple

from ods.base.arrays import Floats32
from ods.compiled.kernel import kernel

_CREST = 0.3
"""An echo's first crest is the first that is so high, in multiples of its highest one."""
_FOOT, _CLEAR = 0.25, 0.6
"""Share of a crest's height at which its slope is read off, and least height there, in multiples of the background."""
_SLOPE = 1.15
"""How far a Gaussian slope goes from half its height to none, in widths of a point, by its steepness near the foot."""


class Crest(NamedTuple):
    """The outermost crest of a run, in columns of the image and multiples of the background over it."""

    edge: float
    """Where a step that has this crest begins."""
    width: float
    """At half its height."""
    height: float


@kernel
def outermost_crest(row: Floats32, ends: tuple[int, int], backwards: bool, background: float, point: float) -> Crest:
    """Return the outermost crest of an echo in columns ends[0] to ends[1] - 1 of a row, at its far end if backwards.

    point: width of a point, columns.
    """
    crest = _crest(row, ends, backwards, background)
    step = -1 if backwards else 1
    height = max(row[crest] - background, 0.01 * background)
    foot = max(_FOOT, min(0.5, _CLEAR * background / height))
    edge = crossing(row, crest, -step, background + foot * height)
    middle = background + 0.5 * height
    width = step * (crossing(row, crest, step, middle) - crossing(row, crest, -step, middle))
    return Crest(edge + step * (0.5 - foot) * _SLOPE * point, width, height / background)


@kernel
def _crest(row: Floats32, ends: tuple[int, int], backwards: bool, background: float) -> int:
    """Return the column of the outermost crest."""
    first, stop = ends
    top = row[first]
    for j in range(first, stop):
        top = max(top, row[j])
    least = background + _CREST * (top - background)
    step, crest, last = (-1, stop - 1, first) if backwards else (1, first, stop - 1)
    while crest != last and (row[crest] < least or row[crest + step] > row[crest]):
        crest += step
    return crest


@kernel
def crossing(row: Floats32, crest: int, step: int, level: float) -> float:
    """Return where a row falls to a level, seen from a crest over it, in columns."""
    j = crest
    while 0 <= j + step < row.size and row[j + step] >= level:
        j += step
    if not 0 <= j + step < row.size:
        return float(j)
    return j + step * float(min(max(row[j] - level, 0.0) / max(row[j] - row[j + step], 1e-30), 1.0))
