"""Single stages of the pipeline on images."""

from collections.abc import Callable

import numpy as np

from ods.base.arrays import Image
from ods.base.settings import Settings
from ods.pipeline import built_in  # noqa: F401  it registers the stages
from ods.pipeline.image.double_buffer import DoubleBuffer
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.registry import find_stage
from ods.pipeline.stage.step import AS_STEP, PingContext

RunStage = Callable[..., Image]
"""run(image, ping=...): what the stage makes of an image, NaN where it writes nothing."""


STANDING_STILL = PingContext(0, None)


def stage_on_images(use: str, fan: Fan, params: Settings | None = None) -> RunStage:
    stage = find_stage(use)
    step = AS_STEP[stage.kind](stage.prepare(params or stage.params(), fan))
    buffers = DoubleBuffer(fan.shape)

    def run(image: Image, ping: PingContext = STANDING_STILL) -> Image:
        buffers.back[:] = image
        source = buffers.flip()
        buffers.back[:] = np.nan
        buffers.apply(step(source, ping, buffers))
        return buffers.front.copy()

    return run
