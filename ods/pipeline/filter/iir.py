"""Recursive filter in range, run both ways: no delay, and a cost that does not depend on its length."""

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.stage.params import IirParams
from ods.pipeline.stage.registry import gained_image_stage
from ods.pipeline.stage.step import GainedImageStep


@gained_image_stage("filter.iir", IirParams)
def iir(params: IirParams, fan: Fan) -> GainedImageStep:
    """First-order low-pass, forwards and backwards: weights fall as exp(-distance / length)."""
    pole = float(np.float32(np.exp(-1.0 / params.length)))
    scale = _scale(pole, fan.samples)

    def step(image: GainedImage, out: Image) -> None:
        native.two_way(image, pole, scale, out)

    return step


def _scale(pole: float, samples: int) -> Floats32:
    """Return 1 / the sum of the weights pole^distance, (samples,): at an end the missing side is left out."""
    missing = pole ** np.arange(1, samples + 1) / (1.0 - pole)
    whole = (1.0 + pole) / (1.0 - pole)
    return np.asarray(1.0 / (whole - missing - missing[::-1]), np.float32)
