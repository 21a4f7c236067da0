"""The recorded samples that an image was made of."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Ints, Ints32, Mask
from ods.compiled import native
from ods.pipeline.image.missing.no_data import ALL_DATA
from ods.pipeline.image.regions import Regions

RegionNumbers = Ints32
"""(beams, samples) number of the detection that a recorded sample belongs to, from 1; 0 for the background."""


class Recorded(NamedTuple):
    """Column j of the image was made of the `stride` samples from `origin[j]` on."""

    samples: AnyArray
    """(beams, samples) of the beams of the image, as they were recorded."""
    origin: Ints
    """(columns,)."""
    stride: int
    missing: Mask = ALL_DATA
    """(beams, samples) those that hold no data; `ALL_DATA` if all do."""


def with_samples_lent(recorded: Recorded) -> Recorded:
    """Return the same with no sample without data in a cell that has some, as a cell is its samples' mean.

    Such samples get the mean of those around that hold data.
    """
    if not recorded.missing.size or recorded.stride == 1:
        return recorded
    samples = recorded.samples.copy()
    native.lend_samples(recorded, samples)
    return recorded._replace(samples=samples)


def cells_without_data(recorded: Recorded) -> Mask:
    """Return the cells of the image, (beams, columns), whose samples all have no data; `ALL_DATA` if there are none."""
    if not recorded.missing.size:
        return ALL_DATA
    cells = np.empty((len(recorded.samples), len(recorded.origin)), np.bool_)
    return cells if native.cells_without_data(recorded, cells) else ALL_DATA


def paint(regions: Regions, before: int, recorded: Recorded, numbers: RegionNumbers) -> None:
    """Write `before` + the region's number to the samples that a region was found in; the others, and those without
    data, stay as they are."""
    for beam, first, stop, region in regions.runs.tolist():
        begin, end = recorded.origin[first], recorded.origin[stop - 1] + recorded.stride
        held = ~recorded.missing[beam, begin:end] if recorded.missing.size else slice(None)
        numbers[beam, begin:end][held] = before + region


def unpaint(numbers: RegionNumbers, gone: Mask) -> None:
    """Take the regions that are gone, (regions,), out of (beams, samples) numbers; the others are renumbered."""
    stay = np.concatenate(([True], ~gone))
    numbers[:] = np.where(stay, np.cumsum(stay) - 1, 0)[numbers]
