"""Connected regions by growing runs of cells from the cells above the high level."""

import numpy as np

from ods.base.arrays import Floats32, Image, Ints32, Mask
from ods.base.kernel import kernel
from ods.pipeline.image.regions import Runs

_BLOCK = 64
"""Cells that are looked at together for one above the high level, in a row that has one."""


@kernel
def find_regions(
    image: Image,
    low: np.float32,
    high: np.float32,
    corner: int,
    smallest: int,
    largest: int,
    runs: Runs,
    visited: Mask,
) -> tuple[int, int]:
    """Fill runs with the runs of all regions; return how many they are, and the number of regions.

    corner: 1 when cells that touch by a corner are connected, 0 when they have to share a side.
    A region is grown, run by run, from a cell of image (beams, samples) above `high`; so the time goes with what is
    found, not with the many cells of speckle above `low`. Cells that are NaN belong to no region. Regions that have not
    `smallest` to `largest` cells get the number 0. runs has room for the most runs there can be; visited must be all
    False and is so again at the end.
    """
    count, end = 0, 0
    for beam in range(image.shape[0]):
        row = image[beam]
        if not _any_above(row, high):
            continue
        for begin in range(0, row.size, _BLOCK):
            end_of_block = min(begin + _BLOCK, row.size)
            if not _any_above(row[begin:end_of_block], high):
                continue
            for column in range(begin, end_of_block):
                if row[column] > high and not visited[beam, column]:
                    stop = _grow(image, low, corner, beam, column, runs, end, visited)
                    if smallest <= _cells(runs[end:stop]) <= largest:
                        count += 1
                        _number(runs[end:stop], count)
                    end = stop
    _forget(runs[:end], visited)
    return end, count


@kernel
def _any_above(row: Floats32, level: np.float32) -> bool:
    count = np.float32(0.0)  # a float, as counting in integers does not vectorise as well
    for j in range(row.size):
        count += np.float32(1.0) if row[j] > level else np.float32(0.0)
    return bool(count > np.float32(0.0))


@kernel
def _grow(
    image: Image, low: np.float32, corner: int, beam: int, column: int, runs: Runs, start: int, visited: Mask
) -> int:
    """Write the runs of the region around one cell to runs[start:stop], as region 0; return stop."""
    stop = start + 1
    _take_run(image[beam], low, beam, column, runs[start], visited[beam])
    i = start
    while i < stop:
        first, last = runs[i, 1] - corner, runs[i, 2] - 1 + corner
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
def _take_run(row: Floats32, low: np.float32, beam: int, column: int, run: Ints32, visited: Mask) -> None:
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
def _forget(runs: Runs, visited: Mask) -> None:
    for i in range(runs.shape[0]):
        for j in range(runs[i, 1], runs[i, 2]):
            visited[runs[i, 0], j] = False
