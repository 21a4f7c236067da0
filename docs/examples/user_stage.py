"""A stage of your own: brings the median of every beam to 1."""

import numpy as np

from ods.base.arrays import Image
from ods.base.settings import Positive, Settings
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.registry import image_stage
from ods.pipeline.stage.step import ImageStep


class BeamGain(Settings, frozen=True):
    """What `[[pipeline.stage]]` may say beside `use = "my.beam_gain"`."""

    limit: Positive = 4.0
    """Factor by which a beam is raised or lowered at most."""


@image_stage("my.beam_gain", BeamGain)
def beam_gain(params: BeamGain, fan: Fan) -> ImageStep:
    """Called once for each geometry of fan; what it returns is called for every image."""

    def step(source: Image, out: Image) -> None:
        median = np.median(source, axis=1, keepdims=True)
        np.divide(source, np.clip(median, 1.0 / params.limit, params.limit), out=out)

    return step
