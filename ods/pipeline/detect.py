"""Two-level detection [SSIE, Image processing, stage 3]: hysteresis thresholds and run-based connected regions."""

import numpy as np
from numpy.typing import NDArray

from ods.pipeline.fan import Fan, Image
from ods.pipeline.kernel import kernel
from ods.pipeline.noise import background_and_noise, new_histogram
from ods.pipeline.params import TwoLevelParams
from ods.pipeline.regions import Regions, Runs
from ods.pipeline.registry import DetectStep, detect_stage

_BLOCK = 64
"""Cells that are looked at together for one above the high level: most of an image is passed over at this pace."""
_LEAST_NOISE = 0.02
"""Of the background: keeps the rounding of a noiseless image from becoming echoes."""

Row = NDArray[np.float32]
Visited = NDArray[np.bool_]
"""(beams, samples) cells that belong to a region already."""


@detect_stage("detect.two_level", TwoLevelParams)
def two_level(params: TwoLevelParams, fan: Fan) -> DetectStep:
    """Find 8-connected regions above the low level in which at least one cell is above the high level."""
    histogram = new_histogram()
    beams, samples = fan.shape
    runs = np.empty((beams * (samples // 2 + 1), 4), np.int32)  # no image has more; untouched pages cost nothing
    visited = np.zeros(fan.shape, np.bool_)

    def step(image: Image) -> Regions:
        background, noise = background_and_noise(image, histogram)
        if background <= 0.0:
            return Regions(runs[:0], 0, 1.0)
        low, high = levels(params, background, noise)
        largest = params.max_cells or image.size
        used, count = find_regions(image, np.float32(low), np.float32(high), params.min_cells, largest, runs, visited)
        return Regions(sorted_runs(runs[:used]), count, background)

    return step


def levels(params: TwoLevelParams, background: float, noise: float) -> tuple[float, float]:
    """Return the low and the high level for an image of this background and noise."""
    if params.levels == "background":
        return params.low * background, params.high * background
    spread = max(noise, _LEAST_NOISE * background)
    return background + params.low * spread, background + params.high * spread


def sorted_runs(runs: Runs) -> Runs:
    """Return the runs of numbered regions, by region, beam and column."""
    runs = runs[runs[:, 3] > 0]
    return runs[np.lexsort((runs[:, 1], runs[:, 0], runs[:, 3]))]


@kernel
def find_regions(
    image: Image, low: np.float32, high: np.float32, smallest: int, largest: int, runs: Runs, visited: Visited
) -> tuple[int, int]:
    """Fill runs with the runs of all regions; return how many they are, and the number of regions.

    A region is grown, run by run, from a cell of image (beams, samples) above `high`; so the time goes with what is
    found, not with the many cells of speckle above `low`. Cells that are NaN belong to no region. Regions that have not
    `smallest` to `largest` cells get the number 0. runs has room for the most runs there can be; visited must be all
    False and is so again at the end.
    """
    count, end = 0, 0
    for beam in range(image.shape[0]):
        row = image[beam]
        for begin in range(0, row.size, _BLOCK):
            block = row[begin : begin + _BLOCK]
            strong = np.float32(0.0)  # a float, as counting in integers does not vectorise as well
            for j in range(block.size):
                strong += np.float32(1.0) if block[j] > high else np.float32(0.0)
            if strong == np.float32(0.0):
                continue
            for column in range(begin, begin + block.size):
                if row[column] > high and not visited[beam, column]:
                    stop = _grow(image, low, beam, column, runs, end, visited)
                    if smallest <= _cells(runs[end:stop]) <= largest:
                        count += 1
                        _number(runs[end:stop], count)
                    end = stop
    _forget(runs[:end], visited)
    return end, count


@kernel
def _grow(image: Image, low: np.float32, beam: int, column: int, runs: Runs, start: int, visited: Visited) -> int:
    """Write the runs of the region around one cell to runs[start:stop], as region 0; return stop."""
    stop = start + 1
    _take_run(image[beam], low, beam, column, runs[start], visited[beam])
    i = start
    while i < stop:
        first, last = runs[i, 1] - 1, runs[i, 2]  # one cell further on both sides: corners touch
        for near in (runs[i, 0] - 1, runs[i, 0] + 1):
            if near < 0 or near >= image.shape[0]:
                continue
            row = image[near]
            for j in range(max(0, first), min(last, row.size - 1) + 1):
                if row[j] > low and not visited[near, j]:
                    _take_run(row, low, near, j, runs[stop], visited[near])
                    stop += 1
        i += 1
    return stop


@kernel
def _take_run(row: Row, low: np.float32, beam: int, column: int, run: NDArray[np.int32], visited: Visited) -> None:
    """Fill run with the cells above `low` around a column of one beam, and mark them."""
    first, stop = column, column + 1
    while first > 0 and row[first - 1] > low:
        first -= 1
    while stop < row.size and row[stop] > low:
        stop += 1
    run[0], run[1], run[2], run[3] = beam, first, stop, 0
    for j in range(first, stop):
        visited[j] = True


@kernel
def _cells(runs: Runs) -> int:
    total = 0
    for i in range(runs.shape[0]):
        total += runs[i, 2] - runs[i, 1]
    return total


@kernel
def _number(runs: Runs, region: int) -> None:
    for i in range(runs.shape[0]):
        runs[i, 3] = region


@kernel
def _forget(runs: Runs, visited: Visited) -> None:
    for i in range(runs.shape[0]):
        for j in range(runs[i, 1], runs[i, 2]):
            visited[runs[i, 0], j] = False
