"""The recorded samples that an image was made of."""

from typing import NamedTuple

from ods.base.arrays import AnyArray, Ints, Ints32, Mask
from ods.compiled.kernel import kernel
from ods.pipeline.image.no_data import ALL_DATA
from ods.pipeline.image.regions import Regions, Run

RegionNumbers = Ints32
"""(beams, samples) number of the detection that a recorded sample belongs to, from 1; 0 for the background."""

_CELLS = 4
"""To either side; fewer would make cells that lack a sample noisier than the others."""


class Recorded(NamedTuple):
    """Column j of the image was made of the `stride` samples from `origin[j]` on."""

    samples: AnyArray
    """(beams, samples) of the beams of the image, as they were recorded."""
    origin: Ints
    """(columns,)."""
    stride: int
    missing: Mask = ALL_DATA
    """(beams, samples) those that hold no data; `ALL_DATA` if all do."""


@kernel
def samples_of(recorded: Recorded, run: Run) -> AnyArray:
    """Return the samples that the cells of a run were made of."""
    begin, stop = recorded.origin[run.first], recorded.origin[run.stop - 1] + recorded.stride
    return recorded.samples[run.beam, begin:stop]


@kernel
def lend_samples(recorded: Recorded, out: AnyArray) -> None:
    """Give samples without data, in cells that have some, the mean of those within _CELLS that hold data.

    out: a copy of `recorded.samples`.
    """
    stride = recorded.stride
    reach = _CELLS * stride
    for b in range(out.shape[0]):
        row, gaps = recorded.samples[b], recorded.missing[b]
        for first in recorded.origin:
            lost = 0
            for j in range(first, first + stride):
                lost += gaps[j]
            if 0 < lost < stride:
                for j in range(first, first + stride):
                    if gaps[j]:
                        out[b, j] = _mean_of_data(row, gaps, max(0, j - reach), min(row.size, j + reach + 1))


@kernel
def _mean_of_data(row: AnyArray, gaps: Mask, begin: int, stop: int) -> float:
    total, count = 0.0, 0
    for k in range(begin, stop):
        if not gaps[k]:
            total += row[k]
            count += 1
    return total / count


def paint(regions: Regions, before: int, recorded: Recorded, numbers: RegionNumbers) -> None:
    """Write `before` + the region's number to the samples that a region was found in; the others, and those without
    data, stay as they are."""
    for beam, first, stop, region in regions.runs.tolist():
        begin, end = recorded.origin[first], recorded.origin[stop - 1] + recorded.stride
        held = ~recorded.missing[beam, begin:end] if recorded.missing.size else slice(None)
        numbers[beam, begin:end][held] = before + region
