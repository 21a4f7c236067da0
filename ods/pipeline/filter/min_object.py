"""Suppression of what is smaller than an object, by grey opening [SSIE, Image processing, stage 2]."""

import numpy as np

from ods.base.arrays import Floats32, Image, Ints
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.params import MinObjectParams
from ods.pipeline.stage.registry import image_stage
from ods.pipeline.stage.step import ImageStep

_MOST_BEAMS = 15
"""Reach across the beams, to either side, very near the sonar."""


@image_stage("filter.min_object", MinObjectParams)
def min_object(params: MinObjectParams, fan: Fan) -> ImageStep:
    """Lower all crests narrower than `size_m`, in range or across, to the level around; larger ones stay as they are.

    The minimum over a window of that size, then the maximum over it. Put it behind a filter that takes out the speckle:
    a dark speckle in an object counts as its end.
    """
    half = max(0, round(0.5 * (params.size_m / fan.dr_m - 1.0)))
    stops = reaches(params.size_m, fan)
    work = np.empty(fan.shape, np.float32)

    def step(source: Image, out: Image) -> None:
        extreme_along(source, half, np.float32(-1.0), work)
        extreme_across(work, stops, np.float32(-1.0), out)
        extreme_along(out, half, np.float32(1.0), work)
        extreme_across(work, stops, np.float32(1.0), out)

    return step


def reaches(size_m: float, fan: Fan) -> Ints:
    """Return, for k = 1, 2, ..., the column up to which a window of size_m reaches k beams to either side."""
    spacing = float(np.diff(fan.borders_rad).mean())
    distance = np.maximum(fan.range_m, fan.dr_m)
    reach = np.floor(0.5 * (size_m / (distance * spacing) - 1.0))
    stops = [int(np.count_nonzero(reach >= k)) for k in range(1, _MOST_BEAMS + 1)]
    return np.array([stop for stop in stops if stop], np.int64)


@kernel
def extreme_along(image: Image, half: int, sign: np.float32, out: Image) -> None:
    """Fill out with the maximum (sign 1) or minimum (sign -1) over `half` samples to either side, cut at the ends."""
    for b in range(image.shape[0]):
        source, target = image[b], out[b]
        for j in range(target.size):
            target[j] = source[j]
        for k in range(1, min(half, target.size - 1) + 1):
            _keep_extreme(source[k:], sign, target[: target.size - k])
            _keep_extreme(source[: target.size - k], sign, target[k:])


@kernel
def extreme_across(image: Image, stops: Ints, sign: np.float32, out: Image) -> None:
    """Fill out with the maximum or minimum over k beams to either side, up to column stops[k - 1]."""
    beams = image.shape[0]
    for b in range(beams):
        out[b, :] = image[b]
        for k in range(1, stops.size + 1):
            stop = stops[k - 1]
            if b - k >= 0:
                _keep_extreme(image[b - k, :stop], sign, out[b, :stop])
            if b + k < beams:
                _keep_extreme(image[b + k, :stop], sign, out[b, :stop])


@kernel
def _keep_extreme(source: Floats32, sign: np.float32, target: Floats32) -> None:
    for j in range(target.size):
        target[j] = source[j] if sign * source[j] > sign * target[j] else target[j]
