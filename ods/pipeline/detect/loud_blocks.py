"""Histograms of the cells of an image where no echo is, and of those where one may be."""

import numpy as np

from ods.base.arrays import Image, Ints
from ods.compiled.kernel import kernel

QUIET, LOUD = 0, 1
"""Rows of the histograms."""
_BLOCK = 32
"""Samples of a beam that are quiet or loud together."""


@kernel
def count_cells(image: Image, rows: tuple[int, int], crest: float, unit: float, histograms: Ints) -> None:
    """Add the cells above 0 of some beams, rows, of image (beams, samples) to histograms (2, bins), bins of 1 / unit.

    Cells in blocks that are, or touch, one with a cell above `crest` go into the second one: they may be an echo's.
    """
    beams, samples = image.shape
    blocks = (samples + _BLOCK - 1) // _BLOCK
    first, stop = max(rows[0] - 1, 0), min(rows[1] + 1, beams)
    loud = np.zeros((stop - first + 2, blocks + 2), np.bool_)
    limit = np.float32(crest)
    for b in range(first, stop):
        for k in range(blocks):
            part = image[b, k * _BLOCK : (k + 1) * _BLOCK]
            above = 0
            for j in range(part.size):
                above += 1 if part[j] > limit else 0
            loud[b - first + 1, k + 1] = above > 0
    scale, last = np.float32(unit), np.float32(histograms.shape[1] - 1)
    for b in range(rows[0], rows[1]):
        for k in range(blocks):
            kind = LOUD if loud[b - first : b - first + 3, k : k + 3].any() else QUIET
            part = image[b, k * _BLOCK : (k + 1) * _BLOCK]
            for j in range(part.size):
                place = part[j] * scale
                positive = 1 if place > np.float32(0.0) else 0  # 0 for NaN
                histograms[kind, np.int32(place if place < last else last)] += positive
