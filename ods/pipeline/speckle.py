"""Images of nothing but speckle, from which detectors learn what the stages before them make of it."""

from collections.abc import Iterator

import numpy as np

from ods.base.arrays import Image
from ods.pipeline.filter_chain import FilterChain
from ods.pipeline.stage.step import PingContext

LEARNT_CELLS = 30_000_000
"""Cells of speckle from which a detector learns its tail, if it has to,"""
_LEARNT_IMAGES = 4
"""and the least number of images,"""
_LEARNT_STEP_NS = 100_000_000
"""so much time apart."""


def filtered_speckle(filters: FilterChain, cells: int) -> Iterator[Image]:
    """Yield what filters make of images of nothing but speckle of mean intensity 1, no two alike; each is soon reused.

    cells: about so many in all.
    """
    rng = np.random.Generator(np.random.SFC64(0))
    buffers = filters.buffers
    for number in range(_LEARNT_IMAGES + cells // buffers.back.size):
        rng.standard_exponential(out=buffers.back, dtype=np.float32)
        np.sqrt(buffers.back, out=buffers.back)
        yield filters.run(buffers.flip(), PingContext(number * _LEARNT_STEP_NS, None))
