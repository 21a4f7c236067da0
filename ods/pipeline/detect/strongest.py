"""Echoes that reach the strongest of the recorded samples: equalization lifts what is nearly silent, and noise too."""

import numpy as np

from ods.base.arrays import AnyArray
from ods.compiled.kernel import kernel
from ods.pipeline.image.recorded import Recorded, samples_of
from ods.pipeline.image.regions import Runs, chosen_runs

_SAMPLES = 4096
"""Samples that the strongest share is measured on."""


def level_of_strongest(recorded: Recorded, share: float) -> float:
    """Return the level that this share of the recorded samples that hold data reaches.

    Looked at are some of them, evenly spread, in steps that never fall in with the rows.
    """
    cells = _in_a_row(recorded.samples)
    step = max(1, cells.size // _SAMPLES) | 1
    some = cells[::step].copy()
    if recorded.missing.size:
        some = some[_in_a_row(recorded.missing)[::step] == 0]
        if not some.size:
            return 0.0
    rank = min(int((1.0 - share) * some.size), some.size - 1)
    if some.dtype.itemsize <= 2:
        some.sort(kind="stable")  # by digits, without a branch: of 4096 counts in a quarter of the time of a partition
    else:
        some.partition(rank)
    return float(some[rank])


def _in_a_row(samples: AnyArray) -> AnyArray:
    return samples.reshape(-1) if samples.flags.c_contiguous else samples.ravel()


@kernel
def without_weak(recorded: Recorded, runs: Runs, total: int, level: float) -> tuple[Runs, int]:
    """Return the regions without those none of whose recorded samples reaches the level, unless that is 0 or less.

    They are numbered anew.
    """
    kept = np.full(total, level <= 0.0)
    for i in range(runs.shape[0]):
        values = samples_of(recorded, runs[i])
        for j in range(values.size):
            if values[j] >= level:
                kept[runs[i].region - 1] = True
                break
    return chosen_runs(runs, kept)
