"""Wiener filter along the beam, or along and across the beams [SSIE, Image processing, stage 2]."""

import numpy as np

from ods.base.arrays import Image
from ods.compiled import native
from ods.pipeline.filter.linear import SeparableFilter, box_weights
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.stage.params import WienerParams
from ods.pipeline.stage.registry import gained_image_stage
from ods.pipeline.stage.step import GainedImageStep


@gained_image_stage("filter.wiener", WienerParams)
def wiener(params: WienerParams, fan: Fan) -> GainedImageStep:
    """Lim's adaptive filter: mean + (sample - mean) * max(0, variance - noise) / variance, over the window.

    The noise is the mean of all local variances (J. S. Lim, Two-Dimensional Signal and Image Processing, 1990, ch. 9).
    """
    window = SeparableFilter(box_weights(params.window), box_weights(params.beams))
    variance = np.empty(fan.shape, np.float32)

    def step(image: GainedImage, out: Image) -> None:
        native.wiener_filter(image, window, variance, out)

    return step
