"""Filters over pings, `ping_iir` and `ping_median`: static objects stand out, speckle and passing things do not."""

import numpy as np

from ods.base.arrays import Image
from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.motion_compensation import MotionCompensator
from ods.pipeline.stage.params import PingIirParams, PingMedianParams
from ods.pipeline.stage.registry import ping_stage
from ods.pipeline.stage.step import PingContext, PingStep


@ping_stage("filter.ping_iir", PingIirParams)
def ping_iir(params: PingIirParams, fan: Fan) -> PingStep:
    """Recursive mean over pings, motion-compensated by the pose where it is given: out = old + weight (new - old)."""
    compensator = MotionCompensator(fan)
    state = np.empty(fan.shape, np.float32)
    former = PingContext(0, None)
    first = True

    def step(source: Image, out: Image, ping: PingContext) -> None:
        nonlocal former, first
        if first or not ping.follows(former, params.longest_gap_s):
            out[:] = source
        else:
            compensator.compensate(state, former.pose, ping.pose, out)
            native.blend(source, params.weight, out)
        state[:] = out
        former, first = ping, False

    return step


@ping_stage("filter.ping_median", PingMedianParams)
def ping_median(params: PingMedianParams, fan: Fan) -> PingStep:
    """Median over pings, motion-compensated by the pose where it is given: takes out what shows in single pings."""
    compensator = MotionCompensator(fan)
    images: list[tuple[Image, PingContext]] = []
    stack = np.empty((params.pings, *fan.shape), np.float32)

    def step(source: Image, out: Image, ping: PingContext) -> None:
        if images and not ping.follows(images[-1][1], params.longest_gap_s):
            images.clear()
        stack[0] = source
        for place, (image, former) in enumerate(images, 1):
            compensator.compensate(image, former.pose, ping.pose, stack[place])
        native.median_of_images(stack, 1 + len(images), out)
        spare = images.pop(0)[0] if len(images) == params.pings - 1 else np.empty_like(source)
        spare[:] = source
        images.append((spare, ping))

    return step
