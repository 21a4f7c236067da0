"""Equalization by place: the mean around each place is brought to 1."""

import numpy as np

from ods.base.arrays import Floats32, Ints
from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.stage.params import LocalParams
from ods.pipeline.stage.registry import gain_stage
from ods.pipeline.stage.step import GainStep


@gain_stage("equalize.local", LocalParams)
def local(params: LocalParams, fan: Fan) -> GainStep:
    """Divide by the mean around each place: levels out beams of different gain and slow changes along the beams.

    The fan is parted into blocks; their means, interpolated in between, are the level. A block counts as within a
    factor of `guard` of its surroundings along the range, so that an object, however wide, does not erase itself. What
    is in the shadow of a wall stays dark beside what is lit: else the lit bottom within a block of it would be raised.
    """
    beams, samples = fan.shape
    beam_edges = np.linspace(0, beams, min(params.beam_blocks, beams) + 1).astype(np.int64)
    range_edges = np.linspace(0, samples, min(params.range_blocks, samples) + 1).astype(np.int64)
    above, share_of_beam = _between(beam_edges)
    before, share_of_column = _between(range_edges)
    rows = np.empty((beam_edges.size - 1, samples), np.float32)

    def step(image: GainedImage) -> GainedImage:
        native.local_gain(image, beam_edges[:-1], range_edges[:-1], before, share_of_column, params.guard, rows)
        return image._replace(gain=rows, above=above, share=share_of_beam, plain=False)

    return step


def _between(edges: Ints) -> tuple[Ints, Floats32]:
    """Return, for each cell, the last block whose middle is not behind it and how far it is on the way to the next."""
    middle = 0.5 * (edges[1:] + edges[:-1] - 1)
    place = np.interp(np.arange(edges[-1]), middle, np.arange(len(middle)))
    block = np.minimum(place.astype(np.int64), max(0, len(middle) - 2))
    return block, (place - block).astype(np.float32)
