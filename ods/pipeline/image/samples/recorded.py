"""The recorded samples that an image was made of."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Ints, Ints32, Mask
from ods.pipeline.image.missing.no_data import ALL_DATA
from ods.pipeline.image.regions import Regions
from ods.pipeline.image.samples.amplitude import SampleScale

RegionNumbers = Ints32
"""(beams, samples) number of the detection that a recorded sample belongs to, from 1; 0 for the background."""


class Frame(NamedTuple):
    """The recorded samples of a ping."""

    samples: AnyArray
    """(all beams, all samples)."""
    scale: SampleScale
    missing: Mask
    """(all beams, all samples) those that hold no data; `ALL_DATA` if all do."""
    number: int
    """Of the ping, less than 2**32."""


class Recorded(NamedTuple):
    """Column j of the image was made of the `stride` samples from `origin[j]` on."""

    samples: AnyArray
    """(beams, samples) of the beams of the image, as they were recorded."""
    origin: Ints
    """(columns,)."""
    stride: int
    missing: Mask = ALL_DATA
    """(beams, samples) those that hold no data; `ALL_DATA` if all do."""


def mark_region(regions: Regions, before: int, recorded: Recorded, numbers: RegionNumbers) -> None:
    """Write `before` + the region's number to the samples that a region was found in; the others, and those without
    data, stay as they are."""
    for beam, first, stop, region in regions.runs.tolist():
        begin, end = recorded.origin[first], recorded.origin[stop - 1] + recorded.stride
        held = ~recorded.missing[beam, begin:end] if recorded.missing.size else slice(None)
        numbers[beam, begin:end][held] = before + region


def unmark_regions(numbers: RegionNumbers, gone: Mask) -> None:
    """Take the regions that are gone, (regions,), out of (beams, samples) numbers; the others are renumbered."""
    stay = np.concatenate(([True], ~gone))
    numbers[:] = np.where(stay, np.cumsum(stay) - 1, 0)[numbers]
