"""Connected regions of an image, as runs of cells along the beams: what a detect stage hands on."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Runs = NDArray[np.int32]
"""(runs, 4) beam, first column, column after the last, region from 1; sorted by region, then beam, then column."""


class Regions(NamedTuple):
    """The echoes of one image."""

    runs: Runs
    total: int
    """Number of regions; they are numbered 1..count without a gap."""
    background: float
    """Level of an image without echoes, above 0: what peak and mean levels are multiples of."""


def paint(runs: Runs, before: int, mask: NDArray[np.int32], stride: int = 1) -> None:
    """Write `before` + the region's number into mask (beams, samples) int32; cells of no region stay as they are.

    stride: columns of mask that make one of the image.
    """
    for beam, first, stop, region in runs.tolist():
        mask[beam, stride * first : stride * stop] = before + region
