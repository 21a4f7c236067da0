"""From regions to echoes: levels, extents, near edge, and the circle that stands for each object."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import Fan, FanTable
from ods.pipeline.image.recorded import Recorded, samples_of
from ods.pipeline.image.regions import Regions, Runs
from ods.pipeline.measure.circle import Circle, circle_of, is_cut
from ods.pipeline.measure.depth import Depth, Ends, Level, depth_of, ends_of

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
    ],
    align=True,
)
"""One echo: the fields of `ods.messages.Detection`, in its order."""

EchoRecord = Any
"""One of them, as kernels get it: numba reads and writes its fields as attributes."""
EchoTable = NDArray[np.void]
"""(regions,) of ECHO."""


def measure_echoes(image: Image, regions: Regions, recorded: Recorded, fan: Fan) -> EchoTable:
    """Return the echoes of the regions that were found in image (beams, samples), which lies as `fan` tells."""
    echoes = np.zeros(regions.total, ECHO)
    _measure_all(image, regions, recorded, fan.table, echoes)
    return echoes


@kernel
def _measure_all(image: Image, regions: Regions, recorded: Recorded, fan: FanTable, echoes: EchoTable) -> None:
    runs, background = regions.runs, regions.background
    whole = ends_of(image, runs, fan)
    start = 0
    for k in range(echoes.shape[0]):
        stop = start
        while stop < runs.shape[0] and runs[stop].region == k + 1:
            stop += 1
        part, ends, echo = runs[start:stop], Ends(whole.near_m[start:stop], whole.far_m[start:stop]), echoes[k]
        beam = _levels(image, part, background, echo)
        _extents(part, fan, echo)
        depth = depth_of(image, part, ends, Level(background, echo.mean, echo.peak), fan)
        _place(circle_of(part, ends, depth, beam, fan, echo.peak), depth, echo)
        echo.amplitude, echo.elevation_rad, echo.cut = (
            _recorded_peak(recorded, part),
            fan.elevation_rad,
            is_cut(part, fan),
        )
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
def _place(circle: Circle, depth: Depth, echo: EchoRecord) -> None:
    """Fill in near edge and circle."""
    echo.near_m, echo.sigma_near_m = depth.near_m, depth.sigma_near_m
    echo.range_m, echo.bearing_rad, echo.radius_m = circle.range_m, circle.bearing_rad, circle.radius_m
    echo.sigma_range_m, echo.sigma_bearing_rad = circle.sigma_range_m, circle.sigma_bearing_rad
    echo.sigma_radius_m = circle.sigma_radius_m
