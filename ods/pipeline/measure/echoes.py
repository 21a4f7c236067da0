"""From regions to echoes: levels, extents, near edge, and the circle that stands for each object."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import Fan, FanTable
from ods.pipeline.image.recorded import Recorded, samples_of
from ods.pipeline.image.regions import Regions, Runs
from ods.pipeline.measure.circle import Crest, circle_of
from ods.pipeline.measure.cut_off import is_cut_beside, is_cut_in_range, widen
from ods.pipeline.measure.depth import Level, depth_of, ends_of
from ods.pipeline.measure.features import EchoRecord, Features, features_of
from ods.pipeline.measure.onset import onset_of
from ods.pipeline.measure.response import point_width, response_width
from ods.pipeline.measure.sigmas import Sigmas, sigmas_of

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
        ("near_m", np.float64),
        ("sigma_near_m", np.float64),
        ("cut", np.bool_),
        ("onset", np.float64),
    ],
    align=True,
)
"""One echo: the fields of `ods.messages.Detection`, in its order."""

EchoTable = NDArray[np.void]
"""(regions,) of ECHO."""


class Doubt(NamedTuple):
    """Standard deviations of what is not seen, m."""

    hidden_m: float
    """How much nearer the body of a fragment begins."""
    beside_m: float
    """Of the place across the line of sight, at most."""
    behind_m: float
    """Of how far the circle's centre is behind the near edge, at most, where the body is seen as a whole."""
    whole: float
    """1: it is; 0: its front."""


def measure_echoes(image: Image, regions: Regions, recorded: Recorded, fan: Fan) -> EchoTable:
    """Return the echoes of the regions that were found in image (beams, samples), which lies as `fan` tells."""
    echoes = np.zeros(regions.total, ECHO)
    _measure_all(image, regions, recorded, fan.table, echoes)
    return echoes


@kernel
def _measure_all(image: Image, regions: Regions, recorded: Recorded, fan: FanTable, echoes: EchoTable) -> None:
    runs, background = regions.runs, regions.background
    point, response = point_width(image, background), response_width(image, background)
    start = 0
    for k in range(echoes.shape[0]):
        stop = start
        while stop < runs.shape[0] and runs[stop].region == k + 1:
            stop += 1
        part, echo = runs[start:stop], echoes[k]
        features, doubt = measure_at(image, part, (background, point), fan, echo)
        _claim(sigmas_of(features, point * fan.dr_m, doubt.beside_m, echo.range_m, fan.dr_m), doubt, echo)
        echo.amplitude = _recorded_peak(recorded, part)
        echo.elevation_rad = fan.elevation_rad
        beside, in_range = is_cut_beside(recorded, part), is_cut_in_range(part, image.shape[1])
        echo.cut = beside or in_range
        if echo.cut:
            widen(echo, beside, in_range)
        else:
            echo.onset = onset_of(image, part, response)
        start = stop


@kernel
def measure_at(
    image: Image, runs: Runs, speckle: tuple[float, float], fan: FanTable, echo: EchoRecord
) -> tuple[Features, Doubt]:
    """Fill in levels, extents, near edge and circle of the echo of these runs.

    speckle: background of the image, and width of a point in it, columns. Returned is what tells how well the circle
    is known.
    """
    background, point = speckle
    beam = _levels(image, runs, background, echo)
    crest = Crest(echo.peak, _contrast(image, runs, echo.peak * background))
    _extents(runs, fan, echo)
    ends = ends_of(image, runs, fan)
    depth = depth_of(image, runs, ends, Level(background, echo.mean), fan)
    circle, shape = circle_of(runs, ends, depth, beam, fan, crest)
    echo.near_m = depth.near_m
    echo.range_m, echo.bearing_rad, echo.radius_m = circle
    doubt = Doubt(depth.hidden_m, shape.beside_m, shape.behind_m, shape.whole)
    return features_of(echo, depth, shape, point * fan.dr_m, fan.dr_m), doubt


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
def _contrast(image: Image, runs: Runs, peak: float) -> float:
    """Return the highest level over the mean of what the runs end at, the lower end of each."""
    total = 0.0
    for i in range(runs.shape[0]):
        row = image[runs[i].beam]
        total += min(row[runs[i].first], row[runs[i].stop - 1])
    return float(max(peak * runs.shape[0] / max(total, 1e-30), 1.0))


@kernel
def _extents(runs: Runs, fan: FanTable, echo: EchoRecord) -> None:
    """Fill in how far the echo reaches, as it was detected."""
    first, stop = runs[0].first, runs[0].stop
    for i in range(runs.shape[0]):
        first, stop = min(first, runs[i].first), max(stop, runs[i].stop)
    echo.range_extent_m = (stop - first) * fan.dr_m
    echo.bearing_extent_rad = fan.borders_rad[runs[-1].beam + 1] - fan.borders_rad[runs[0].beam]


@kernel
def _claim(sigmas: Sigmas, doubt: Doubt, echo: EchoRecord) -> None:
    """Fill in the standard deviations.

    That of the near edge is at least what of a fragment may be hidden. The centre is not better known than it, and that
    of a whole body hardly worse.
    """
    echo.sigma_near_m, echo.sigma_radius_m = max(sigmas.near_m, doubt.hidden_m), sigmas.radius_m
    along, limit = max(sigmas.range_m, echo.sigma_near_m), np.hypot(echo.sigma_near_m, doubt.behind_m)
    echo.sigma_range_m = along + doubt.whole * (min(along, limit) - along)
    echo.sigma_bearing_rad = sigmas.bearing_rad
