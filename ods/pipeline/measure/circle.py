"""The circle that stands for an echo's body, with the beam's width taken out.

Across the beams, an echo is wider than its object, because a beam of -3 dB width w also hears its surroundings with a
Gaussian directivity. In the outermost beam an object's edge at distance x inside or outside the beam's axis leaves the
share q = Phi(x / s), s = w / 2.355, of the intensity that the beams further in show: so the level of that beam tells
where the edge is.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import FanTable
from ods.pipeline.image.regions import Runs
from ods.pipeline.measure.depth import Depth, Ends
from ods.pipeline.measure.enclosing_circle import Points, smallest_circle

_SIGMA_OF_WIDTH = 1.0 / 2.3548
"""Standard deviation of a Gaussian directivity in units of its -3 dB width (full width at half intensity)."""
_LOGIT_OF_PROBIT = 1.702
"""Phi(x) is 1 / (1 + exp(-1.702 x)) to within 0.01."""
_LIMB = 0.8
"""Exponent of the outermost beam's share: a round body is darker at its edge [SSIE eq. 3] even without a beam's blur.
1 fits flat discs, 0.6 spheres."""
_LONE_BEAM = 0.7
"""Widest object, in units of a cell, that is seen in one beam alone."""
_RESOLVED = 2.0
"""Echoes narrower than this many beam widths show no shape: they are taken for round,"""
_WIDEST = 3.0
"""and for no wider than this many times their depth: a sphere's front is seen to 0.3 to 0.6 of its radius."""
_BLURRED, _FLAT = 0.15, 0.5
"""Largest standard deviation of an echo's place across the line of sight: of what is small in widths of the beam, of a
flat front in its own width."""
_INSIDE, _ACROSS = 0.03, 0.04
"""Largest standard deviation of where the middle of a whole body is behind its near edge: in radii, and in widths of
the beam, together with the doubt about what it is."""
_SMALL_M = 0.3
"""Up to this radius the centre is the middle of what shines, as small bodies often shine all over; from twice as much
on it is a radius behind the near edge."""


class Circle(NamedTuple):
    """A circle in the sonar's plane: fields of `ods.messages.Detection`."""

    range_m: float
    bearing_rad: float
    radius_m: float


class Crest(NamedTuple):
    """How loud an echo is."""

    peak: float
    """In multiples of the background,"""
    contrast: float
    """and of the mean of the lower ends of its runs: over a rough sea-bed an echo ends at higher levels."""


class Shape(NamedTuple):
    """What an echo shows of its body's shape."""

    whole: float
    """1: all of it; 0: its front."""
    roundness: float
    """1: a convex front; 0: a flat one."""
    long_m: float
    """Along the line of sight."""
    wide_m: float
    """Across it, without the beam's width."""
    blur_m: float
    """Width of the beam there."""
    beams: int
    contrast: float
    """Of its `Crest`."""
    beside_m: float
    """Largest standard deviation of its place across the line of sight,"""
    behind_m: float
    """and, where it is of a whole body, of how far the circle's centre is behind the near edge."""


class Width(NamedTuple):
    """An echo across the line of sight, rad, with the beam's width taken out."""

    left: float
    right: float
    blur: float
    """-3 dB width of the beam."""


@kernel
def circle_of(runs: Runs, ends: Ends, depth: Depth, beam: Floats, fan: FanTable, crest: Crest) -> tuple[Circle, Shape]:
    """Return the circle of the echo of these runs, and what it shows of the body's shape.

    beam: intensity of each of the echo's beams.
    """
    bearing, borders = fan.bearing_rad, fan.borders_rad
    low, high = runs[0].beam, runs[-1].beam
    long, middle = depth.far_m - depth.near_m, 0.5 * (depth.near_m + depth.far_m)
    width = _width(beam, low, fan)
    wide = max(width.right - width.left, 0.0)
    resolved = wide >= _RESOLVED * width.blur and beam.size > 2
    across = wide if resolved else min(wide, _WIDEST * long / max(middle, fan.dr_m))
    centre = 0.5 * (width.left + width.right)
    left, right = centre - 0.5 * across, centre + 0.5 * across
    points = _outline(runs, ends, borders, left - borders[low], borders[high + 1] - right, centre)
    x, y, radius = smallest_circle(points)
    blur_m, wide_m = width.blur * middle, wide * middle
    whole, roundness = depth.whole * _as_deep_as_wide(long, wide_m, blur_m, resolved), 1.0
    if resolved:
        roundness = max(_roundness(runs, ends.near_m, bearing, centre, 0.5 * across * middle), whole)
    radius *= 1.0 + roundness / crest.contrast**3  # of a weak front the highlights show
    doubt = abs(0.5 * long - radius) * np.sqrt(whole * (1.0 - whole))
    radius = max(radius + whole * (0.5 * long - radius), 0.5 * fan.dr_m)
    distance, not_small = np.hypot(x, y), min(max(radius / _SMALL_M - 1.0, 0.0), 1.0)
    distance += roundness * not_small * (depth.near_m + radius - distance)
    beside = _beside(roundness, max(wide_m, blur_m), blur_m, crest.peak)
    behind = np.sqrt(doubt**2 + (_INSIDE * radius) ** 2 + (_ACROSS * blur_m) ** 2)
    shape = Shape(whole, roundness, long, wide_m, blur_m, beam.size, crest.contrast, beside, behind)
    return Circle(distance, np.arctan2(y, x), radius), shape


@kernel
def _beside(roundness: float, wide: float, blur: float, peak: float) -> float:
    """Return the largest standard deviation of an echo's place across the line of sight, m.

    Of what shines with speckle, the middle is known to its width over its level; a flat front may be seen in part.
    """
    return float(np.hypot(_BLURRED * blur, (roundness / peak + (1.0 - roundness) * _FLAT) * wide))


@kernel
def _width(beam: Floats, low: int, fan: FanTable) -> Width:
    """Return from where to where an echo reaches. beam: intensity of each of its beams, the first of which is `low`."""
    high = low + beam.size - 1
    bearing, borders = fan.bearing_rad[low : high + 1], fan.borders_rad
    blur = fan.beam_width_rad[(low + high) // 2]
    left = bearing[0] - _overhang(beam, bearing, blur, borders[low + 1] - borders[low], False)
    right = bearing[-1] + _overhang(beam, bearing, blur, borders[high + 1] - borders[high], True)
    return Width(left, right, blur)


@kernel
def _overhang(beam: Floats, bearing: Floats, blur: float, cell: float, backwards: bool) -> float:
    """Return how far an object reaches beyond the axis of the outermost beam of its echo, rad; negative inside.

    beam, bearing: intensity and axis of the echo's beams; the last one is the outermost one when `backwards`.
    """
    count = beam.size
    if count == 1:
        return 0.5 * _LONE_BEAM * cell
    begin, step = (count - 1, -1) if backwards else (0, 1)
    inner = 0.0
    for k in range(1, count):
        inner = max(inner, beam[begin + step * k])
        if abs(bearing[begin + step * k] - bearing[begin]) >= 0.75 * blur:
            break
    share = min(max((beam[begin] / max(inner, 1e-30)) ** _LIMB, 1e-6), 0.999)
    outside = _SIGMA_OF_WIDTH * blur * np.log(share / (1.0 - share)) / _LOGIT_OF_PROBIT
    return float(min(max(outside, -max(blur, cell)), 0.5 * cell))


@kernel
def _outline(runs: Runs, ends: Ends, borders: Floats, left: float, right: float, centre: float) -> Points:
    """Return the corners of all runs in the sonar's plane, (4 runs, 2) ahead and to starboard, m.

    Corners on the left of `centre` are moved `left` rad towards it, the others `right` rad, and never across it.
    """
    points = np.empty((4 * runs.shape[0], 2))
    for i in range(runs.shape[0]):
        for side in range(2):
            border = borders[runs[i].beam + side]
            angle = min(border + left, centre) if border < centre else max(border - right, centre)
            k = 4 * i + 2 * side
            points[k, 0], points[k, 1] = ends.near_m[i] * np.cos(angle), ends.near_m[i] * np.sin(angle)
            points[k + 1, 0], points[k + 1, 1] = ends.far_m[i] * np.cos(angle), ends.far_m[i] * np.sin(angle)
    return points


@kernel
def _roundness(runs: Runs, near: Floats, bearing: Floats, centre: float, half_width: float) -> float:
    """Return 1 for an echo with a convex front, 0 for a flat one, by the curvature of a parabola through the front.

    The curvature times the half width is 0.6 for a sphere of which 40 deg to each side are seen, at least 0.2 when the
    beams blur it, and within +-0.1 for a wall with speckle.
    """
    across = np.empty(runs.shape[0])  # position of each beam's front, from left to right
    ahead = np.empty(runs.shape[0])
    count = 0
    nearest = np.inf  # of the runs of one beam
    for i in range(runs.shape[0]):
        nearest = min(nearest, near[i])
        if i + 1 == runs.shape[0] or runs[i + 1].beam != runs[i].beam:
            angle = bearing[runs[i].beam] - centre
            across[count], ahead[count] = nearest * np.sin(angle), nearest * np.cos(angle)
            count += 1
            nearest = np.inf
    if count < 3:
        return 0.0
    curvature = 2.0 * _square_term(across[:count], ahead[:count])
    return float(min(max((curvature * half_width - 0.05) / 0.2, 0.0), 1.0))


@kernel
def _square_term(x: Floats, y: Floats) -> float:
    """Return c of the parabola y = a + b x + c x^2 that fits best, by polynomials orthogonal on the points x."""
    count = x.size
    mean, second, third = 0.0, 0.0, 0.0
    for i in range(count):
        mean += x[i] / count
    for i in range(count):
        away = x[i] - mean
        second += away * away
        third += away * away * away
    product, square = 0.0, 0.0
    for i in range(count):
        away = x[i] - mean
        term = away * away - away * third / second - second / count
        product += y[i] * term
        square += term * term
    return product / max(square, 1e-30)


@kernel
def _as_deep_as_wide(long: float, wide: float, blur: float, resolved: bool) -> float:
    """Return 1 for an echo as deep as it is wide, as that of a whole body is, and 0 for one half as deep.

    A width that the beam does not resolve is that much wider, and proves little: at least 0.5.
    """
    if not resolved:
        wide = np.sqrt(max(wide**2 - blur**2, 1e-6))
    alike = min(max(5.0 * (long / max(wide, 1e-3) - 0.5), 0.0), 1.0)
    return alike if resolved else 0.5 + 0.5 * alike
