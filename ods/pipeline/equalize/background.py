"""Equalization by what stays in its place in the image over pings."""

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.equalize.by_range import blocks_around, limit_levels
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
    level = np.empty(fan.samples, np.float32)
    reach = blocks_around(MeanRangeParams().window)
    guard = np.float32(params.guard)
    former = PingContext(0, None)
    count = 0

    def step(source: Image, out: Image, ping: PingContext) -> None:
        nonlocal former, count
        if not ping.follows(former, params.longest_gap_s):
            count = 0
        count += 1
        weight = max(params.weight, 1.0 / count)
        update_background(source, np.float32(weight), level, state)
        limit_levels(level, guard, reach)
        divide_by_background(source, guard, level, state, out)
        former = ping

    return step


@kernel
def update_background(source: Image, weight: np.float32, level: Floats32, state: Image) -> None:
    """Update state (beams, samples), the mean over pings, and fill level (samples,) with its mean over the beams."""
    beams = source.shape[0]
    level[:] = np.float32(0.0)
    for b in range(beams):
        new, mean = source[b], state[b]
        for j in range(level.size):
            mean[j] += weight * (new[j] - mean[j])
        for j in range(level.size):
            level[j] += mean[j]
    for j in range(level.size):
        level[j] /= np.float32(beams)


@kernel
def divide_by_background(source: Image, guard: np.float32, level: Floats32, state: Image, out: Image) -> None:
    """Fill out with source over state, which counts as within a factor of guard of level (samples,)."""
    for b in range(source.shape[0]):
        new, mean, target = source[b], state[b], out[b]
        for j in range(level.size):
            limit = min(max(mean[j], level[j] / guard), level[j] * guard)
            target[j] = limit if limit > np.float32(0.0) else np.float32(1.0)
        for j in range(level.size):
            target[j] = new[j] / target[j]
