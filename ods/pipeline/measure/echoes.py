"""From regions to echoes: the circle that stands for each object, with sub-cell edges and the beam's width taken out.

Along the beam, an echo ends where it has half the level of its outermost crest: a symmetric filter leaves that point in
place, whatever the threshold. Across the beams, an echo is wider than its object, because a beam of -3 dB width w also
hears its surroundings with a Gaussian directivity. In the outermost beam an object's edge at distance x inside or
outside the beam's axis leaves the share q = Phi(x / s), s = w / 2.355, of the intensity that the beams further in show:
so the level of that beam tells where the edge is.
"""

import numpy as np

from ods.base.arrays import AnyArray, Floats, Floats32, Image
from ods.base.kernel import kernel
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import Regions, Runs
from ods.pipeline.measure.enclosing_circle import Points, smallest_circle

FIELDS = (
    "range_m",
    "bearing_rad",
    "radius_m",
    "peak",
    "mean",
    "snr_db",
    "cells",
    "range_extent_m",
    "bearing_extent_rad",
    "sigma_range_m",
    "sigma_bearing_rad",
    "sigma_radius_m",
    "amplitude",
)
"""Columns of the table of echoes: the fields of `ods.messages.Detection` of these names."""

Table = Floats

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
"""Echoes narrower than this many beam widths show no shape: they are taken for round."""

_HIDDEN_M = 5.0
"""Standard deviation of the place of an object of which the fan's edge hides a part."""


def measure_echoes(image: Image, frame: AnyArray, first: int, stride: int, regions: Regions, fan: Fan) -> Table:
    """Return the (regions, len(FIELDS)) table of echoes.

    image: (beams, samples) that the regions were found in; frame: the recorded samples, columns `first` to
    `first + stride - 1` of which are column 0 of the image.
    """
    table = np.zeros((regions.total, len(FIELDS)))
    if regions.total:
        _measure_all(
            image, regions.runs, regions.background, fan.bearing_rad, fan.borders_rad, fan.beam_width_rad,
            fan.range0_m, fan.dr_m, table,
        )  # fmt: skip
        _raw_peaks(frame, first, stride, regions.runs, table)
    return table


@kernel
def _raw_peaks(frame: AnyArray, first: int, stride: int, runs: Runs, table: Table) -> None:
    for i in range(runs.shape[0]):
        values = frame[runs[i, 0], first + stride * runs[i, 1] : first + stride * runs[i, 2]]
        for j in range(values.size):
            table[runs[i, 3] - 1, -1] = max(table[runs[i, 3] - 1, -1], values[j])


@kernel
def _measure_all(
    image: Image,
    runs: Runs,
    background: float,
    bearing: Floats,
    borders: Floats,
    width: Floats,
    range0: float,
    dr: float,
    table: Table,
) -> None:
    edges = np.empty((runs.shape[0], 2))
    for i in range(runs.shape[0]):
        row = image[runs[i, 0], runs[i, 1] : runs[i, 2]]
        edges[i, 0] = range0 + (runs[i, 1] + _edge(row, False) - 0.5) * dr
        edges[i, 1] = range0 + (runs[i, 2] - _edge(row, True) - 0.5) * dr
    start = 0
    for k in range(table.shape[0]):
        stop = start
        while stop < runs.shape[0] and runs[stop, 3] == k + 1:
            stop += 1
        part, ends, echo = runs[start:stop], edges[start:stop], table[k]
        beam = _levels(image, part, background, echo)
        _extents(part, borders, dr, echo)
        _circle(part, ends, beam, bearing, borders, width, dr, echo)
        start = stop


@kernel
def _edge(row: Floats32, backwards: bool) -> int:
    """Return how many cells lie outside the point of half the level of the first crest, seen from one end of a run."""
    last = row.size - 1
    step = -1 if backwards else 1
    begin = last if backwards else 0
    crest = 0
    while crest < last and row[begin + step * (crest + 1)] > row[begin + step * crest]:
        crest += 1
    half = np.float32(0.5) * row[begin + step * crest]
    outside = 0
    while outside < crest and row[begin + step * outside] < half:
        outside += 1
    return min(outside, last // 2)


@kernel
def _levels(image: Image, runs: Runs, background: float, echo: Floats) -> Floats:
    """Fill in peak, mean, snr_db and cells; return the peak intensity over the background's of each beam."""
    beam = np.zeros(runs[-1, 0] - runs[0, 0] + 1)
    total, cells, peak = 0.0, 0, 0.0
    for i in range(runs.shape[0]):
        row = image[runs[i, 0], runs[i, 1] : runs[i, 2]]
        best = 0.0
        for j in range(row.size):
            total += row[j]
            best = max(best, row[j])
        cells += row.size
        peak = max(peak, best)
        k = runs[i, 0] - runs[0, 0]
        beam[k] = max(beam[k], best * best - background * background)
    echo[3] = peak / background
    echo[4] = total / cells / background
    echo[5] = 20.0 * np.log10(max(peak / background, 1e-6))
    echo[6] = cells
    return beam


@kernel
def _extents(runs: Runs, borders: Floats, dr: float, echo: Floats) -> None:
    """Fill in how far the echo reaches, as it was detected."""
    first, stop = runs[0, 1], runs[0, 2]
    for i in range(runs.shape[0]):
        first, stop = min(first, runs[i, 1]), max(stop, runs[i, 2])
    echo[7] = (stop - first) * dr
    echo[8] = borders[runs[-1, 0] + 1] - borders[runs[0, 0]]


@kernel
def _circle(
    runs: Runs, ends: Points, beam: Floats, bearing: Floats, borders: Floats, width: Floats, dr: float, echo: Floats
) -> None:
    """Fill in the circle and its standard deviations."""
    low, high = runs[0, 0], runs[-1, 0]
    near, far = ends[0, 0], ends[0, 1]
    for i in range(ends.shape[0]):
        near, far = min(near, ends[i, 0]), max(far, ends[i, 1])
    middle = 0.5 * (near + far)
    blur = width[(low + high) // 2]
    left = bearing[low] - _overhang(beam, bearing[low : high + 1], blur, borders[low + 1] - borders[low], False)
    right = bearing[high] + _overhang(beam, bearing[low : high + 1], blur, borders[high + 1] - borders[high], True)
    across = max(right - left, 0.0)
    resolved = across >= _RESOLVED * blur
    if not resolved:
        across = min(across, 2.0 * (far - near) / max(middle, dr))
    centre = 0.5 * (left + right)
    left, right = centre - 0.5 * across, centre + 0.5 * across
    points = _outline(runs, ends, borders, left - borders[low], borders[high + 1] - right, centre)
    x, y, radius = smallest_circle(points)
    radius = max(radius, 0.5 * dr)
    distance = np.hypot(x, y)
    roundness = _roundness(runs, ends, bearing, centre, 0.5 * across * middle) if resolved else 1.0
    behind = distance + roundness * max(near + radius - distance, 0.0)
    echo[0] = min(behind, max(distance, far))  # not behind the echo's end
    echo[1] = np.arctan2(y, x)
    echo[2] = radius
    _spread(blur, across, middle, echo)
    if low == 0 or high == bearing.size - 1:
        _cut_off(echo)


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
def _outline(runs: Runs, ends: Points, borders: Floats, left: float, right: float, centre: float) -> Points:
    """Return the corners of all runs in the sonar's plane, (4 runs, 2) ahead and to starboard, m.

    Corners on the left of `centre` are moved `left` rad towards it, the others `right` rad, and never across it.
    """
    points = np.empty((4 * runs.shape[0], 2))
    for i in range(runs.shape[0]):
        for side in range(2):
            border = borders[runs[i, 0] + side]
            angle = min(border + left, centre) if border < centre else max(border - right, centre)
            for end in range(2):
                k = 4 * i + 2 * side + end
                points[k, 0], points[k, 1] = ends[i, end] * np.cos(angle), ends[i, end] * np.sin(angle)
    return points


@kernel
def _roundness(runs: Runs, ends: Points, bearing: Floats, centre: float, half_width: float) -> float:
    """Return 1 for an echo with a convex front, 0 for a flat one, by the curvature of a parabola through the front.

    The curvature times the half width is 0.6 for a sphere of which 40 deg to each side are seen, at least 0.2 when the
    beams blur it, and within +-0.1 for a wall with speckle.
    """
    across = np.empty(runs.shape[0])  # position of each beam's front, from left to right
    ahead = np.empty(runs.shape[0])
    count = 0
    nearest = np.inf  # of the runs of one beam
    for i in range(runs.shape[0]):
        nearest = min(nearest, ends[i, 0])
        if i + 1 == runs.shape[0] or runs[i + 1, 0] != runs[i, 0]:
            angle = bearing[runs[i, 0]] - centre
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
def _spread(blur: float, across: float, middle: float, echo: Floats) -> None:
    """Fill in the standard deviations, of the whole body and not of what shines of it.

    Fitted, half and half, to ideal bodies that shine all over and to the simulator's spheres, of which weak ones show
    no more than a highlight: there the body goes on by an unknown length behind the echo and beside it.
    """
    echo[9] = np.hypot(0.5 * blur * middle, 0.41 * echo[2])
    echo[10] = np.hypot(0.18 * blur, 0.035 * across)
    echo[11] = np.hypot(0.51 * blur * middle, 0.15 * echo[2])


@kernel
def _cut_off(echo: Floats) -> None:
    """Widen the standard deviations of an echo that the fan's edge cuts off.

    How far the object goes on beyond the edge nobody knows, and the error stays the same from ping to ping.
    """
    echo[9] = np.hypot(echo[9], echo[2])
    echo[10] = np.hypot(echo[10], _HIDDEN_M / max(echo[0], _HIDDEN_M))
    echo[11] = np.hypot(echo[11], _HIDDEN_M)
