"""Equalization: the average at each range is brought to 1 [SSIE, Image processing, stage 1]."""

import numpy as np
from numpy.typing import NDArray

from ods.pipeline.fan import Fan, Image
from ods.pipeline.kernel import kernel
from ods.pipeline.params import MeanRangeParams
from ods.pipeline.registry import ImageStep, image_stage

Row = NDArray[np.float32]

_BLOCK = 32
"""Columns that share one value of the surroundings' level."""


@image_stage("equalize.mean_range", MeanRangeParams)
def mean_range(params: MeanRangeParams, fan: Fan) -> ImageStep:
    """Divide each range by its mean over the beams, but never by more than `guard` times its surroundings' mean.

    The guard is what keeps a wall, which fills the sector at its range, from erasing itself; slow changes, belts wider
    than half the window and drop-outs are levelled in full. A range of zeros stays zero.
    """
    level = np.empty(fan.samples, np.float32)
    blocks = np.empty(-(-fan.samples // _BLOCK), np.float32)
    reach = max(1, params.window // (2 * _BLOCK))
    nearby = np.empty(2 * reach + 1, np.float32)
    guard = np.float32(params.guard)

    def step(source: Image, out: Image) -> None:
        range_means(source, level)
        limit_levels(level, guard, blocks, nearby)
        divide_columns(source, level, out)

    return step


@kernel
def range_means(image: Image, means: Row) -> None:
    """Fill means (samples,) with the mean over the beams of image (beams, samples)."""
    means[:] = np.float32(0.0)
    for b in range(image.shape[0]):
        row = image[b]
        for j in range(means.size):
            means[j] += row[j]
    share = np.float32(1.0 / image.shape[0])
    for j in range(means.size):
        means[j] *= share


@kernel
def limit_levels(level: Row, guard: np.float32, blocks: Row, nearby: Row) -> None:
    """Limit level (samples,) to guard times its surroundings' level, in place.

    The surroundings' level is the median of block means over nearby.size blocks around, so an edge of a belt keeps its
    place. blocks (ceil(samples / 32),) and nearby (odd,) are work space.
    """
    count = blocks.size
    for k in range(count):
        part = level[k * _BLOCK : (k + 1) * _BLOCK]
        total = np.float32(0.0)
        for j in range(part.size):
            total += part[j]
        blocks[k] = total / np.float32(part.size)
    reach = nearby.size // 2
    for k in range(count):
        first, last = max(0, k - reach), min(count, k + reach + 1)
        limit = guard * sorted_middle(blocks[first:last], nearby)
        part = level[k * _BLOCK : (k + 1) * _BLOCK]
        for j in range(part.size):
            part[j] = min(part[j], limit)


@kernel
def sorted_middle(values: Row, work: Row) -> np.float32:
    """Return the (lower) median of a few values; work has room for them."""
    for i in range(values.size):
        value = values[i]
        k = i
        while k > 0 and work[k - 1] > value:
            work[k] = work[k - 1]
            k -= 1
        work[k] = value
    return work[(values.size - 1) // 2]


@kernel
def divide_columns(image: Image, level: Row, out: Image) -> None:
    """Fill out with image (beams, samples) divided by level (samples,); 0 where the level is 0."""
    gain = np.empty(level.size, np.float32)
    for j in range(level.size):
        gain[j] = np.float32(1.0) / level[j] if level[j] > np.float32(0.0) else np.float32(0.0)
    for b in range(image.shape[0]):
        source = image[b]
        target = out[b]
        for j in range(gain.size):
            target[j] = source[j] * gain[j]
