"""Connected regions by growing runs of cells from the cells above the high level."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats32, Image, Mask
from ods.compiled.kernel import kernel
from ods.pipeline.image.regions import RUN, Run, Runs, sorted_runs

NOT_A_NUMBER = -1
"""Instead of a number of regions: the image has cells that are no finite numbers."""
_BLOCK = 64
"""Cells that are looked at together for one above the high level, in a row that has one."""


class GrowingRule(NamedTuple):
    """Which cells make a region."""

    low: np.float32
    """Cells above it belong to a region,"""
    high: np.float32
    """which has at least one above this."""
    corner: int
    """1 when cells that touch by a corner are connected, 0 when they have to share a side."""
    smallest: int
    largest: int
    """Cells of a region."""


def room_for_runs(shape: tuple[int, int]) -> Runs:
    """Return room for the most runs an image of (beams, samples) can have; what is not written costs no memory."""
    beams, samples = shape
    return np.empty(beams * (samples // 2 + 1), RUN)


@kernel
def find_regions(image: Image, rule: GrowingRule, work: Runs, visited: Mask) -> tuple[Runs, int]:
    """Return the runs of all regions, sorted, and the number of regions.

    A region is grown, run by run, from a cell of image (beams, samples) above `high`; so the time goes with what is
    found, not with the many cells of speckle above `low`. NaN or infinity anywhere: no runs, and `NOT_A_NUMBER`.
    work: as `room_for_runs` makes it; visited, (beams, samples), must be all False and is so again at the end.
    """
    high = rule.high
    count, end = 0, 0
    for beam in range(image.shape[0]):
        row = image[beam]
        if _all_up_to(row, high):
            continue
        for begin in range(0, row.size, _BLOCK):
            end_of_block = min(begin + _BLOCK, row.size)
            if _all_up_to(row[begin:end_of_block], high):
                continue
            for column in range(begin, end_of_block):
                if not np.isfinite(row[column]):
                    _forget(work[:end], visited)
                    return work[:0], NOT_A_NUMBER
                if row[column] > high and not visited[beam, column]:
                    stop = end + _grow(image, rule, (beam, column), work[end:], visited)
                    if rule.smallest <= _cells(work[end:stop]) <= rule.largest:
                        count += 1
                        _number(work[end:stop], count)
                    end = stop
    _forget(work[:end], visited)
    return sorted_runs(work[:end]), count


@kernel
def _all_up_to(row: Floats32, level: np.float32) -> bool:
    """Tell whether no cell is above the level, nor NaN."""
    count = np.float32(0.0)  # a float, as counting in integers does not vectorise as well
    for j in range(row.size):
        count += np.float32(0.0) if row[j] <= level else np.float32(1.0)
    return bool(count == np.float32(0.0))


@kernel
def _grow(image: Image, rule: GrowingRule, seed: tuple[int, int], runs: Runs, visited: Mask) -> int:
    """Write the runs of the region around one cell, as region 0; return how many they are."""
    low, corner = rule.low, rule.corner
    count = 1
    _take_run(image[seed[0]], low, seed, runs[0], visited[seed[0]])
    i = 0
    while i < count:
        first, last = runs[i].first - corner, runs[i].stop - 1 + corner
        for near in (runs[i].beam - 1, runs[i].beam + 1):
            if near < 0 or near >= image.shape[0]:
                continue
            row = image[near]
            for j in range(max(0, first), min(last, row.size - 1) + 1):
                if row[j] > low and not visited[near, j]:
                    _take_run(row, low, (near, j), runs[count], visited[near])
                    count += 1
        i += 1
    return count


@kernel
def _take_run(row: Floats32, low: np.float32, seed: tuple[int, int], run: Run, visited: Mask) -> None:
    """Fill run with the cells above `low` around a (beam, column), and mark them."""
    beam, column = seed
    first, stop = column, column + 1
    while first > 0 and row[first - 1] > low:
        first -= 1
    while stop < row.size and row[stop] > low:
        stop += 1
    run.beam, run.first, run.stop, run.region = beam, first, stop, 0
    for j in range(first, stop):
        visited[j] = True


@kernel
def _cells(runs: Runs) -> int:
    total = 0
    for i in range(runs.shape[0]):
        total += runs[i].stop - runs[i].first
    return total


@kernel
def _number(runs: Runs, region: int) -> None:
    for i in range(runs.shape[0]):
        runs[i].region = region


@kernel
def _forget(runs: Runs, visited: Mask) -> None:
    for i in range(runs.shape[0]):
        for j in range(runs[i].first, runs[i].stop):
            visited[runs[i].beam, j] = False
