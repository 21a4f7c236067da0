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
"""Cells that are looked at together: most of an image is passed over at this pace."""


@detect_stage("detect.two_level", TwoLevelParams)
def two_level(params: TwoLevelParams, fan: Fan) -> DetectStep:
    """Find 8-connected regions above the low level in which at least one cell is above the high level."""
    histogram = new_histogram()
    beams, samples = fan.shape
    found = np.empty((beams * (samples // 2 + 1), 4), np.int32)  # a row can hold no more runs; untouched pages are free
    strong = np.empty(len(found), np.bool_)

    def step(image: Image) -> Regions:
        background, noise = background_and_noise(image, histogram)
        if background <= 0.0:
            return Regions(found[:0], 0, 1.0)
        low, high = levels(params, background, noise)
        runs = find_runs(image, np.float32(low), np.float32(high), params.gap, found, strong)
        kept, count = keep_regions(found[:runs], strong, params.min_cells, params.max_cells or image.size)
        return Regions(kept, count, background)

    return step


def levels(params: TwoLevelParams, background: float, noise: float) -> tuple[float, float]:
    """Return the low and the high level for an image of this background and noise."""
    if params.levels == "background":
        return params.low * background, params.high * background
    spread = max(noise, _LEAST_NOISE * background)
    return background + params.low * spread, background + params.high * spread


_LEAST_NOISE = 0.02
"""Of the background: keeps the rounding of a noiseless image from becoming echoes."""


@kernel
def find_runs(image: Image, low: np.float32, high: np.float32, gap: int, runs: Runs, strong: NDArray[np.bool_]) -> int:
    """Fill runs with the runs of cells above `low` of image (beams, samples), linked to regions; return their number.

    Column 3 of runs is the index of another run of the same region, in the end its first (union-find by smaller index).
    strong says whether a run has a cell above `high`. Cells that are NaN belong to no run.
    """
    count = 0
    above = 0  # first run of the beam before
    for b in range(image.shape[0]):
        start = count
        count = _runs_of_row(image[b], b, low, high, gap, runs, strong, count)
        _link(runs, above, start, count)
        above = start
    for i in range(count):
        runs[i, 3] = runs[runs[i, 3], 3]
    return count


@kernel
def _runs_of_row(
    row: NDArray[np.float32],
    beam: int,
    low: np.float32,
    high: np.float32,
    gap: int,
    runs: Runs,
    strong: NDArray[np.bool_],
    count: int,
) -> int:
    start = count
    for begin in range(0, row.size, _BLOCK):
        block = row[begin : begin + _BLOCK]
        above = 0
        for j in range(block.size):
            above += block[j] > low
        if above == 0:
            continue
        for j in range(block.size):
            if not block[j] > low:
                continue
            column = begin + j
            if count == start or column > runs[count - 1, 2] + gap:
                runs[count, 0], runs[count, 1], runs[count, 3] = beam, column, count
                strong[count] = False
                count += 1
            runs[count - 1, 2] = column + 1
            strong[count - 1] |= block[j] > high
    return count


@kernel
def _link(runs: Runs, above: int, start: int, stop: int) -> None:
    """Join runs start..stop of one beam with those, above..start, of the beam before that touch them, corners too."""
    i, k = above, start
    while i < start and k < stop:
        if runs[i, 1] <= runs[k, 2] and runs[k, 1] <= runs[i, 2]:
            a, b = _root(runs, i), _root(runs, k)
            runs[max(a, b), 3] = min(a, b)
        if runs[i, 2] < runs[k, 2]:
            i += 1
        else:
            k += 1


@kernel
def _root(runs: Runs, index: int) -> int:
    while runs[index, 3] != index:
        runs[index, 3] = runs[runs[index, 3], 3]
        index = runs[index, 3]
    return index


@kernel
def keep_regions(runs: Runs, strong: NDArray[np.bool_], min_cells: int, max_cells: int) -> tuple[Runs, int]:
    """Return the runs of the regions that are strong somewhere and of the right size, numbered from 1, and their number."""
    total = runs.shape[0]
    cells = np.zeros(total, np.int32)
    length = np.zeros(total, np.int32)
    exists = np.zeros(total, np.bool_)
    for i in range(total):
        root = runs[i, 3]
        cells[root] += runs[i, 2] - runs[i, 1]
        length[root] += 1
        exists[root] |= strong[i]
    place = np.full(total, -1, np.int32)  # where the next run of a region goes
    number = np.zeros(total, np.int32)
    count, used = 0, 0
    for i in range(total):
        if exists[i] and min_cells <= cells[i] <= max_cells:
            count += 1
            number[i], place[i] = count, used
            used += length[i]
    kept = np.empty((used, 4), np.int32)
    for i in range(total):
        root = runs[i, 3]
        if place[root] >= 0:
            k = place[root]
            kept[k, 0], kept[k, 1], kept[k, 2], kept[k, 3] = runs[i, 0], runs[i, 1], runs[i, 2], number[root]
            place[root] = k + 1
    return kept, count
