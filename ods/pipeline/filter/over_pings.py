"""Filters over pings, `ping_iir` and `ping_median`: static objects stand out, speckle and passing things do not."""

import numpy as np

from ods.base.arrays import Image
from ods.base.frames.geometry import rotation_matrix
from ods.compiled import native
from ods.messages import Pose
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.params import PingIirParams, PingMedianParams
from ods.pipeline.stage.registry import ping_stage
from ods.pipeline.stage.step import PingContext, PingStep
from ods.pose.buffer import PoseEstimate

KNOT = 32
"""Columns between two places whose way is computed exactly."""


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


class MotionCompensator:
    """Resamples images taken from one pose to what they would show from another."""

    def __init__(self, fan: Fan) -> None:
        columns = np.minimum(np.arange(0, fan.samples - 1 + KNOT, KNOT), fan.samples - 1)
        distance = fan.range0_m + columns * fan.dr_m
        angle = fan.bearing_rad[:, None]
        self._fan = fan
        self._points = np.stack([distance * np.cos(angle), distance * np.sin(angle), np.zeros_like(distance * angle)])
        self._number = np.arange(len(fan.bearing_rad), dtype=np.float64)

    def compensate(
        self, image: Image, before: Pose | PoseEstimate | None, now: Pose | PoseEstimate | None, out: Image
    ) -> None:
        """Fill out with image, taken at pose `before`, as seen from pose `now`; less than 0 where it does not reach.

        All in the fan's plane, and of objects that stand still [SSIE eq. 1].
        """
        if before is None or now is None:
            out[:] = image
            return
        fan = self._fan
        away = np.subtract(now.position_ned, before.position_ned)
        old = rotation_matrix(before.attitude).T
        turned = np.tensordot(old @ rotation_matrix(now.attitude), self._points, 1) + (old @ away)[:, None, None]
        column = (np.hypot(turned[0], turned[1]) - fan.range0_m) / fan.dr_m
        bearing = np.arctan2(turned[1], turned[0])
        half = 0.5 * float(fan.beam_width_rad[0])
        beam = np.interp(bearing, fan.bearing_rad, self._number)
        beam[(bearing < fan.bearing_rad[0] - half) | (bearing > fan.bearing_rad[-1] + half)] = -1e6
        native.resample(image, column, beam, KNOT, out)
