"""Images without echoes, from which detectors learn what the stages before them make of speckle."""

from collections.abc import Callable, Iterator

import numpy as np

from ods.base.arrays import Image
from ods.base.clock import NS
from ods.pipeline.prepared.filter_chain import FilterChain
from ods.pipeline.stage.step import PingContext

LEARNT_IMAGES = 8

Alive = Callable[[], object]
"""Is called now and then during work that takes long, so that it is not taken for hung."""


def filtered_speckle(filters: FilterChain, stride: int, alive: Alive | None = None) -> Iterator[Image]:
    """Yield what filters make of images of speckle of mean intensity 1, no two alike; each is soon reused.

    stride: samples whose amplitudes are averaged to a cell's. alive: is called before each image.
    """
    rng, buffers = np.random.Generator(np.random.SFC64(0)), filters.buffers
    beams, columns = buffers.back.shape
    samples = np.empty((beams, columns * stride), np.float32)
    for number in range(LEARNT_IMAGES):
        if alive:
            alive()
        rng.standard_exponential(out=samples, dtype=np.float32)
        np.sqrt(samples, out=samples)
        np.mean(samples.reshape(beams, columns, stride), axis=2, out=buffers.back)
        yield filters.run(buffers.flip(), PingContext(number * NS // 10, None))
