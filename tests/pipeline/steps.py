"""Single stages of the pipeline, and measuring, on images."""

from collections.abc import Callable

import numpy as np

from ods.base.arrays import Image
from ods.base.settings import Settings
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import DoubleBuffer
from ods.pipeline.image.regions import RUN, Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.measure.echoes import Measured, measure
from ods.pipeline.prepared.filter_chain import result_of
from ods.pipeline.stage.configured import find_stage
from ods.pipeline.stage.step import PingContext
from tests.pipeline.pings import fan_bearings

RunStage = Callable[..., Image]
"""run(image, ping=...): what the stage makes of an image, NaN where it writes nothing."""


STANDING_STILL = PingContext(0, None)
DR_M = 0.05


def stage_on_images(use: str, fan: Fan, params: Settings | None = None) -> RunStage:
    stage = find_stage(use)
    step = stage.prepare(params or stage.params(), fan)
    buffers = DoubleBuffer(fan.shape)

    def run(image: Image, ping: PingContext = STANDING_STILL) -> Image:
        buffers.back[:] = image
        source = buffers.flip()
        buffers.back[:] = np.nan
        buffers.apply(result_of(stage.kind, step, source, ping, buffers))
        return buffers.front.copy()

    return run


def measured(image: Image, runs: list[tuple[int, int, int]]) -> Measured:
    """Return what is measured of one region of an image (beams, columns): its beams, first columns and those behind."""
    beams, columns = image.shape
    fan = Fan(fan_bearings(beams), np.full(beams, np.radians(1.5)), columns, 1.0, DR_M)
    region = np.array([(*run, 1) for run in runs], RUN)
    image = np.ascontiguousarray(image, np.float32)
    return measure(image, Regions(region, int(region.size > 0), 1.0), Recorded(image, np.arange(columns), 1), fan)
