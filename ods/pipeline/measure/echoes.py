"""From regions to echoes: the circle that stands for each object, with sub-cell edges and the beam's width taken out.

Along the beam, an echo ends where it has half the level of its outermost crest: a symmetric filter leaves that point in
place, whatever the threshold. Across the beams, an echo is wider than its object, because a beam of -3 dB width w also
hears its surroundings with a Gaussian directivity. In the outermost beam an object's edge at distance x inside or
outside the beam's axis leaves the share q = Phi(x / s), s = w / 2.355, of the intensity that the beams further in show:
so the level of that beam tells where the edge is.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import Fan, FanTable
from ods.pipeline.image.recorded import Recorded, samples_of
from ods.pipeline.image.regions import Regions, Runs
from ods.pipeline.measure.enclosing_circle import Points, smallest_circle

ECHO = np.dtype(
    [
        ("range_m", np.float64),
        ("bearing_rad", np.float64),
        ("radius_m", np.float64),
        ("peak", np.float64),
        ("mean", np.float64),
        ("snr_db", np.float64),
        ("cells", np.int64),
        ("range_extent_m", np.float64),
        ("bearing_extent_rad", np.float64),
        ("sigma_range_m", np.float64),
        ("sigma_bearing_rad", np.float64),
        ("sigma_radius_m", np.float64),
        ("amplitude", np.float64),
        ("elevation_rad", np.float64),
    ],
    align=True,
)
"""One echo: the fields of `ods.messages.Detection`, in its order."""

EchoRecord = Any
"""One of them, as kernels get it: numba reads and writes its fields as attributes."""
EchoTable = NDArray[np.void]
"""(regions,) of ECHO."""

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


class Ends(NamedTuple):
    """Where runs begin and end, with sub-cell accuracy."""

    near_m: Floats
    """(runs,) slant range."""
    far_m: Floats


def measure_echoes(image: Image, regions: Regions, recorded: Recorded, fan: Fan) -> EchoTable:
    """Return the echoes of the regions that were found in image (beams, samples), which lies as `fan` tells."""
    echoes = np.zeros(regions.total, ECHO)
    _measure_all(image, regions, recorded, fan.table, echoes)
    return echoes


@kernel
def _measure_all(image: Image, regions: Regions, recorded: Recorded, fan: FanTable, echoes: EchoTable) -> None:
    runs, background = regions.runs, regions.background
    near, far = np.empty(runs.shape[0]), np.empty(runs.shape[0])
    for i in range(runs.shape[0]):
        run = runs[i]
        row = image[run.beam, run.first : run.stop]
        near[i] = fan.range0_m + (run.first + _edge(row, False) - 0.5) * fan.dr_m
        far[i] = fan.range0_m + (run.stop - _edge(row, True) - 0.5) * fan.dr_m
    start = 0
    for k in range(echoes.shape[0]):
        stop = start
        while stop < runs.shape[0] and runs[stop].region == k + 1:
            stop += 1
        part, ends, echo = runs[start:stop], Ends(near[start:stop], far[start:stop]), echoes[k]
        beam = _levels(image, part, background, echo)
        _extents(part, fan, echo)
        _circle(part, ends, beam, fan, echo)
        echo.amplitude, echo.elevation_rad = _recorded_peak(recorded, part), fan.elevation_rad
        start = stop


@kernel
def _recorded_peak(recorded: Recorded, runs: Runs) -> float:
    """Return the highest recorded sample, 0 where all are negative."""
    peak = 0.0
    for i in range(runs.shape[0]):
        values = samples_of(recorded, runs[i])
        for j in range(values.size):
            peak = max(peak, values[j])
    return peak


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
def _levels(image: Image, runs: Runs, background: float, echo: EchoRecord) -> Floats:
    """Fill in peak, mean, snr_db and cells; return the peak intensity over the background's of each beam."""
    beam = np.zeros(runs[-1].beam - runs[0].beam + 1)
    total, cells, peak = 0.0, 0, 0.0
    for i in range(runs.shape[0]):
        row = image[runs[i].beam, runs[i].first : runs[i].stop]
        best = 0.0
        for j in range(row.size):
            total += row[j]
            best = max(best, row[j])
        cells += row.size
        peak = max(peak, best)
        k = runs[i].beam - runs[0].beam
        beam[k] = max(beam[k], best * best - background * background)
    echo.peak = peak / background
    echo.mean = total / cells / background
    echo.snr_db = 20.0 * np.log10(max(peak / background, 1e-6))
    echo.cells = cells
    return beam


@kernel
def _extents(runs: Runs, fan: FanTable, echo: EchoRecord) -> None:
    """Fill in how far the echo reaches, as it was detected."""
    first, stop = runs[0].first, runs[0].stop
    for i in range(runs.shape[0]):
        first, stop = min(first, runs[i].first), max(stop, runs[i].stop)
    echo.range_extent_m = (stop - first) * fan.dr_m
    echo.bearing_extent_rad = fan.borders_rad[runs[-1].beam + 1] - fan.borders_rad[runs[0].beam]


@kernel
def _circle(runs: Runs, ends: Ends, beam: Floats, fan: FanTable, echo: EchoRecord) -> None:
    """Fill in the circle and its standard deviations. beam: intensity of each of the echo's beams."""
    bearing, borders, dr = fan.bearing_rad, fan.borders_rad, fan.dr_m
    low, high = runs[0].beam, runs[-1].beam
    near, far = ends.near_m[0], ends.far_m[0]
    for i in range(runs.shape[0]):
        near, far = min(near, ends.near_m[i]), max(far, ends.far_m[i])
    middle = 0.5 * (near + far)
    blur = fan.beam_width_rad[(low + high) // 2]
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
    roundness = _roundness(runs, ends.near_m, bearing, centre, 0.5 * across * middle) if resolved else 1.0
    behind = distance + roundness * max(near + radius - distance, 0.0)
    echo.range_m = min(behind, max(distance, far))  # not behind the echo's end
    echo.bearing_rad = np.arctan2(y, x)
    echo.radius_m = radius
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
def _spread(blur: float, across: float, middle: float, echo: EchoRecord) -> None:
    """Fill in the standard deviations, of the whole body and not of what shines of it.

    Fitted, half and half, to ideal bodies that shine all over and to the simulator's spheres, of which weak ones show
    no more than a highlight: there the body goes on by an unknown length behind the echo and beside it.
    """
    echo.sigma_range_m = np.hypot(0.5 * blur * middle, 0.41 * echo.radius_m)
    echo.sigma_bearing_rad = np.hypot(0.18 * blur, 0.035 * across)
    echo.sigma_radius_m = np.hypot(0.51 * blur * middle, 0.15 * echo.radius_m)


@kernel
def _cut_off(echo: EchoRecord) -> None:
    """Widen the standard deviations of an echo that the fan's edge cuts off.

    How far the object goes on beyond the edge nobody knows, and the error stays the same from ping to ping.
    """
    echo.sigma_range_m = np.hypot(echo.sigma_range_m, echo.radius_m)
    echo.sigma_bearing_rad = np.hypot(echo.sigma_bearing_rad, _HIDDEN_M / max(echo.range_m, _HIDDEN_M))
    echo.sigma_radius_m = np.hypot(echo.sigma_radius_m, _HIDDEN_M)
