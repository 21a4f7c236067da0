"""Connected regions by growing runs of cells from the cells above the high level."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Image, Mask
from ods.compiled import native
from ods.pipeline.detect.background.rise import NO_RISE, Rise
from ods.pipeline.image.regions import RUN, Runs
from ods.pipeline.stage.params import NotANumberError


class GrowingRule(NamedTuple):
    """Which cells make a region; levels are compared as float32."""

    low: float
    """Cells above it belong to a region,"""
    high: float
    """which has at least one above this."""
    corner: int
    """1 when cells that touch by a corner are connected, 0 when they have to share a side."""
    smallest: int
    largest: int
    """Cells of a region."""
    rise: Rise = NO_RISE
    """Of both levels."""


def room_for_runs(shape: tuple[int, int]) -> Runs:
    """Return room for the most runs an image of (beams, samples) can have; what is not written costs no memory."""
    beams, samples = shape
    return np.empty(beams * (samples // 2 + 1), RUN)


def find_regions(image: Image, rule: GrowingRule, work: Runs, visited: Mask) -> tuple[Runs, int]:
    """Return the runs of all regions of image (beams, samples), sorted, and the number of regions; they lie in `work`.

    work: as `room_for_runs` makes it; visited, (beams, samples), must be all False and is so again at the end.
    Raises NotANumberError where a cell is not finite.
    """
    count = native.find_regions(image, rule, work, visited)
    if count < 0:
        raise NotANumberError
    runs = work[:count]
    return runs, int(runs["region"][-1]) if count else 0
