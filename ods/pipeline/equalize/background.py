"""Equalization by what stays in its place in the image over pings."""

import numpy as np

from ods.base.arrays import Image
from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.params import BackgroundParams, MeanRangeParams
from ods.pipeline.stage.registry import ping_stage
from ods.pipeline.stage.step import PingContext, PingStep


@ping_stage("equalize.background", BackgroundParams)
def background(params: BackgroundParams, fan: Fan) -> PingStep:
    """Divide each cell by its mean over pings: what stays in its place in the image, whatever the vehicle does.

    That is the sonar's own: gain of beams and ranges, interference, the glow of a level bottom. The mean is limited to
    `guard` times the mean of its own range, and that one to `guard` times the level of the ranges around, so that an
    object the vehicle stands before, or a wall across the sector, does not vanish.
    """
    state = np.ones(fan.shape, np.float32)
    window = MeanRangeParams().window
    former = PingContext(0, None)
    count = 0

    def step(source: Image, out: Image, ping: PingContext) -> None:
        nonlocal former, count
        if not ping.follows(former, params.longest_gap_s):
            count = 0
        count += 1
        weight = max(params.weight, 1.0 / count)
        native.equalize_by_background(source, weight, params.guard, window, state, out)
        former = ping

    return step
