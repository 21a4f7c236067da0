"""Median filter along the beam, and across."""

from ods.base.arrays import Image
from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.stage.params import MedianParams
from ods.pipeline.stage.registry import gained_image_stage
from ods.pipeline.stage.step import GainedImageStep


@gained_image_stage("filter.median", MedianParams)
def median(params: MedianParams, _fan: Fan) -> GainedImageStep:
    """Median of a window of range samples: takes out speckle and keeps edges where they are.

    Across the beams, the median of the beams' medians: almost the median of the whole window, at a tenth of its cost.
    """

    def step(image: GainedImage, out: Image) -> None:
        native.median_filter(image, params.window, params.beams, out)

    return step
