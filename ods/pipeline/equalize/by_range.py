"""Equalization by range, `mean_range` and `median_range`: the average there is brought to 1 [SSIE, Image processing,
stage 1]."""

import numpy as np

from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.stage.params import MeanRangeParams, MedianRangeParams
from ods.pipeline.stage.registry import gain_stage
from ods.pipeline.stage.step import GainStep


@gain_stage("equalize.mean_range", MeanRangeParams)
def mean_range(params: MeanRangeParams, fan: Fan) -> GainStep:
    """Divide each range by its mean over the beams, but never by more than `guard` times its surroundings' mean.

    The guard is what keeps a wall, which fills the sector at its range, from erasing itself; slow changes, belts wider
    than half the window and drop-outs are levelled in full. Side lobes of a strong echo are levelled out of the other
    beams. A range of zeros stays zero.
    """
    side_lobe = 10.0 ** (-params.side_lobe_db / 20.0)
    gain = np.empty((1, fan.samples), np.float32)

    def step(image: GainedImage) -> GainedImage:
        native.mean_range_gain(image, side_lobe, params.guard, params.window, gain)
        return image._replace(gain=gain, plain=False)

    return step


@gain_stage("equalize.median_range", MedianRangeParams)
def median_range(params: MedianRangeParams, fan: Fan) -> GainStep:
    """Divide each range by its median over the beams: what fills less than half of the sector does not count.

    The median is brought to the mean that speckle has (1.064 of the median of a Rayleigh distribution).
    """
    gain = np.empty((1, fan.samples), np.float32)

    def step(image: GainedImage) -> GainedImage:
        native.median_range_gain(image, params.guard, params.window, gain)
        return image._replace(gain=gain, plain=False)

    return step
