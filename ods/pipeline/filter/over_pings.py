"""Filters and background over pings: static objects stand out, speckle and passing things do not."""

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.base.kernel import kernel
from ods.pipeline.equalize.by_range import Limiter, limit_levels
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.motion_compensation import Look, PingStep, Turner
from ods.pipeline.stage.params import BackgroundParams, MeanRangeParams, PingIirParams, PingMedianParams
from ods.pipeline.stage.registry import ping_stage


@ping_stage("filter.ping_iir", PingIirParams)
def ping_iir(params: PingIirParams, fan: Fan) -> PingStep:
    """Recursive mean over pings, motion-compensated by the pose where it is given: out = old + weight (new - old)."""
    turner = Turner(fan)
    state = np.empty(fan.shape, np.float32)
    former = Look(0, None)
    first = True

    def run(source: Image, out: Image, look: Look) -> None:
        nonlocal former, first
        if first or stale(former, look, params.longest_gap_s):
            out[:] = source
        else:
            turner.turn(state, former.pose, look.pose, out)
            blend(source, np.float32(params.weight), out)
        state[:] = out
        former, first = look, False

    return PingStep(run)


@ping_stage("filter.ping_median", PingMedianParams)
def ping_median(params: PingMedianParams, fan: Fan) -> PingStep:
    """Median over pings, motion-compensated by the pose where it is given: takes out what shows in single pings."""
    turner = Turner(fan)
    images: list[tuple[Floats32, Look]] = []
    stack = np.empty((params.pings, *fan.shape), np.float32)

    def run(source: Image, out: Image, look: Look) -> None:
        if images and stale(images[-1][1], look, params.longest_gap_s):
            images.clear()
        stack[0] = source
        for place, (image, former) in enumerate(images, 1):
            turner.turn(image, former.pose, look.pose, stack[place])
        median_of_images(stack, 1 + len(images), out)
        spare = images.pop(0)[0] if len(images) == params.pings - 1 else np.empty_like(source)
        spare[:] = source
        images.append((spare, look))

    return PingStep(run)


@ping_stage("equalize.background", BackgroundParams)
def background(params: BackgroundParams, fan: Fan) -> PingStep:
    """Divide each cell by its mean over pings: what stays in its place in the image, whatever the vehicle does.

    That is the sonar's own: gain of beams and ranges, interference, the glow of a level bottom. The mean is limited to
    `guard` times the mean of its own range, and that one to `guard` times the level of the ranges around, so that an
    object the vehicle stands before, or a wall across the sector, does not vanish.
    """
    state = np.ones(fan.shape, np.float32)
    level = np.empty(fan.samples, np.float32)
    limiter = Limiter(MeanRangeParams(guard=params.guard), fan)
    guard = np.float32(params.guard)
    former = Look(0, None)
    count = 0

    def run(source: Image, out: Image, look: Look) -> None:
        nonlocal former, count
        if stale(former, look, params.longest_gap_s):
            count = 0
        count += 1
        weight = max(params.weight, 1.0 / count)
        update_background(source, np.float32(weight), level, state)
        limit_levels(level, *limiter.args)
        divide_by_background(source, guard, level, state, out)
        former = look

    return PingStep(run)


def stale(former: Look, look: Look, longest_gap_s: float) -> bool:
    """Tell whether the former ping is too old, or later, to say anything about this one."""
    return not 0 <= look.t_ns - former.t_ns <= longest_gap_s * 1e9


@kernel
def blend(source: Image, weight: np.float32, out: Image) -> None:
    """Move out, the former mean or below 0 where there is none, towards source by weight."""
    for b in range(out.shape[0]):
        new, mean = source[b], out[b]
        for j in range(mean.size):
            old = mean[j] if mean[j] >= np.float32(0.0) else new[j]
            mean[j] = old + weight * (new[j] - old)


@kernel
def median_of_images(stack: Image, count: int, out: Image) -> None:
    """Fill out with the (lower) median over the first `count` images of stack (n, beams, samples), unknown left out."""
    work = np.empty(stack.shape[0], np.float32)
    for b in range(out.shape[0]):
        for j in range(out.shape[1]):
            known = 0
            for k in range(count):
                value = stack[k, b, j]
                if value < np.float32(0.0):
                    continue
                place = known
                while place > 0 and work[place - 1] > value:
                    work[place] = work[place - 1]
                    place -= 1
                work[place] = value
                known += 1
            out[b, j] = work[(known - 1) // 2] if known else np.float32(0.0)


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
