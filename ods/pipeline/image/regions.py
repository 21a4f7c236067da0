"""Connected regions of an image, as runs of cells along the beams: what a detect stage hands on."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Mask
from ods.compiled.kernel import kernel

RUN = np.dtype([("beam", np.int32), ("first", np.int32), ("stop", np.int32), ("region", np.int32)], align=True)
"""Neighbouring cells of one beam: columns `first` to `stop` - 1. Regions are numbered from 1."""
Run = Any
"""One of them, as kernels get it: numba reads and writes its fields as attributes."""
Runs = NDArray[np.void]
"""(runs,) of RUN; sorted by region, then beam, then column."""


class Regions(NamedTuple):
    """The echoes of one image."""

    runs: Runs
    total: int
    """Number of regions; they are numbered 1..total without a gap."""
    background: float
    """Level of an image without echoes, above 0: what peak and mean levels are multiples of."""


def shared_at(regions: Regions, column: int) -> tuple[Regions, Regions]:
    """Return the regions that lie before a column that none reaches across, and the others."""
    beyond = regions_beyond(regions, column)
    return chosen(regions, ~beyond), chosen(regions, beyond)


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
        region = runs[i].region - 1
        if wanted[region]:
            out[count] = runs[i]
            out[count].region = number[region]
            count += 1
    return out[:count], number[-1] if number.size else 0


@kernel
def regions_beyond(regions: Regions, column: int) -> Mask:
    """Return, (total,), whether a region lies behind a column that none reaches across."""
    beyond = np.zeros(regions.total, np.bool_)
    for i in range(regions.runs.shape[0]):
        run = regions.runs[i]
        beyond[run.region - 1] = run.first >= column
    return beyond


@kernel
def renumber(runs: Runs, kept: Mask) -> int:
    """Number the regions to keep anew, from 1 without a gap, the others 0; return how many stay. kept: (total + 1,)."""
    number = np.zeros(kept.size, np.int32)
    count = 0
    for region in range(1, kept.size):
        if kept[region]:
            count += 1
            number[region] = count
    for i in range(runs.shape[0]):
        runs[i].region = number[runs[i].region]
    return count
