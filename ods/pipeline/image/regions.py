"""Connected regions of an image, as runs of cells along the beams: what a detect stage hands on."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Ints32, Mask
from ods.base.kernel import kernel

Runs = Ints32
"""(runs, 4) beam, first column, column after the last, region from 1; sorted by region, then beam, then column."""


class Regions(NamedTuple):
    """The echoes of one image."""

    runs: Runs
    total: int
    """Number of regions; they are numbered 1..count without a gap."""
    background: float
    """Level of an image without echoes, above 0: what peak and mean levels are multiples of."""


def paint(runs: Runs, before: int, mask: Ints32, first: int = 0, stride: int = 1) -> None:
    """Write `before` + the region's number into mask (beams, samples) int32; cells of no region stay as they are.

    Columns `first` to `first + stride - 1` of mask make column 0 of the image.
    """
    for beam, begin, stop, region in runs.tolist():
        mask[beam, first + stride * begin : first + stride * stop] = before + region


def shared_at(regions: Regions, column: int) -> tuple[Regions, Regions]:
    """Return the regions that lie before a column that none reaches across, and the others."""
    before, count, beyond, rest = shared_runs(regions.runs, regions.total, column)
    return Regions(before, count, regions.background), Regions(beyond, rest, regions.background)


def chosen(regions: Regions, wanted: Mask) -> Regions:
    """Return the wanted regions, (total,), numbered anew without a gap."""
    runs, total = chosen_runs(regions.runs, wanted)
    return Regions(runs, total, regions.background)


@kernel
def chosen_runs(runs: Runs, wanted: Mask) -> tuple[Runs, int]:
    """Return the runs of the wanted regions, numbered anew without a gap, and the number of regions."""
    number = np.cumsum(wanted)
    out = np.empty_like(runs)
    count = 0
    for i in range(runs.shape[0]):
        region = runs[i, 3] - 1
        if wanted[region]:
            out[count] = runs[i]
            out[count, 3] = number[region]
            count += 1
    return out[:count], number[-1] if number.size else 0


@kernel
def shared_runs(runs: Runs, total: int, column: int) -> tuple[Runs, int, Runs, int]:
    """Return runs and number of the regions before a column that none reaches across, and of the others."""
    beyond = np.zeros(total, np.bool_)
    for i in range(runs.shape[0]):
        beyond[runs[i, 3] - 1] = runs[i, 1] >= column
    near, count = chosen_runs(runs, ~beyond)
    far, rest = chosen_runs(runs, beyond)
    return near, count, far, rest
