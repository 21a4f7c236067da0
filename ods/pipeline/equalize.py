"""Equalization: the average at each range, or around each place, is brought to 1 [SSIE, Image processing, stage 1]."""

import numpy as np
from numpy.typing import NDArray

from ods.pipeline.fan import Fan, Image
from ods.pipeline.kernel import kernel
from ods.pipeline.params import LocalParams, MeanRangeParams
from ods.pipeline.registry import ImageStep, image_stage

Row = NDArray[np.float32]

_BLOCK = 32
"""Columns that share one value of the surroundings' level."""


@image_stage("equalize.mean_range", MeanRangeParams)
def mean_range(params: MeanRangeParams, fan: Fan) -> ImageStep:
    """Divide each range by its mean over the beams, but never by more than `guard` times its surroundings' mean.

    The guard is what keeps a wall, which fills the sector at its range, from erasing itself; slow changes, belts wider
    than half the window and drop-outs are levelled in full. Side lobes of a strong echo are levelled out of the other
    beams. A range of zeros stays zero.
    """
    level = np.empty(fan.samples, np.float32)
    highest = np.empty(fan.samples, np.float32)
    blocks = np.empty(-(-fan.samples // _BLOCK), np.float32)
    reach = max(1, params.window // (2 * _BLOCK))
    nearby = np.empty(2 * reach + 1, np.float32)
    guard = np.float32(params.guard)
    side_lobe = np.float32(10.0 ** (-params.side_lobe_db / 20.0))

    def step(source: Image, out: Image) -> None:
        range_means(source, level)
        limit_levels(level, guard, blocks, nearby)
        np.max(source, axis=0, out=highest)
        np.maximum(level, side_lobe * highest, out=level)
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
    return np.float32(work[(values.size - 1) // 2])


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


@image_stage("equalize.local", LocalParams)
def local(params: LocalParams, fan: Fan) -> ImageStep:
    """Divide by the mean around each place: levels out beams of different gain and slow changes along the beams.

    The fan is parted into blocks; their means, interpolated in between, are the level. A block counts as within a
    factor of `guard` of its surroundings along the range, so that an object, however wide, does not erase itself.
    """
    beams, samples = fan.shape
    beam_edges = np.linspace(0, beams, min(params.beam_blocks, beams) + 1).astype(np.int64)
    range_edges = np.linspace(0, samples, min(params.range_blocks, samples) + 1).astype(np.int64)
    means = np.empty((beam_edges.size - 1, range_edges.size - 1), np.float32)
    gain = np.empty_like(means)
    rows = np.empty((len(means), samples), np.float32)
    above, share_of_beam = _between(beam_edges)
    before, share_of_column = _between(range_edges)
    guard = np.float32(params.guard)

    def step(source: Image, out: Image) -> None:
        block_means(source, beam_edges, range_edges, means)
        block_gains(means, guard, gain)
        interpolate_columns(gain, before, share_of_column, rows)
        multiply_interpolated(source, rows, above, share_of_beam, out)

    return step


def _between(edges: NDArray[np.int64]) -> tuple[NDArray[np.int64], Row]:
    """Return, for each cell, the last block whose middle is not behind it and how far it is on the way to the next."""
    middle = 0.5 * (edges[1:] + edges[:-1] - 1)
    place = np.interp(np.arange(edges[-1]), middle, np.arange(len(middle)))
    block = np.minimum(place.astype(np.int64), max(0, len(middle) - 2))
    return block, (place - block).astype(np.float32)


@kernel
def block_means(image: Image, beam_edges: NDArray[np.int64], range_edges: NDArray[np.int64], means: Image) -> None:
    """Fill means (beam blocks, range blocks) with the mean of image (beams, samples) over each block."""
    for p in range(means.shape[0]):
        means[p, :] = np.float32(0.0)
        for b in range(beam_edges[p], beam_edges[p + 1]):
            for q in range(means.shape[1]):
                part = image[b, range_edges[q] : range_edges[q + 1]]
                total = np.float32(0.0)
                for j in range(part.size):
                    total += part[j]
                means[p, q] += total
        for q in range(means.shape[1]):
            means[p, q] /= np.float32((beam_edges[p + 1] - beam_edges[p]) * (range_edges[q + 1] - range_edges[q]))


@kernel
def block_gains(means: Image, guard: np.float32, gain: Image) -> None:
    """Fill gain with 1 / means (beam blocks, range blocks), 1 where there is no mean.

    A mean is limited to a factor of guard of the median of five blocks along the range: what lasts there is a beam's
    gain, what does not is an object, however wide, or the dark that the equalization per range leaves beside it.
    """
    work = np.empty(5, np.float32)
    for p in range(means.shape[0]):
        for q in range(means.shape[1]):
            around = sorted_middle(means[p, max(0, q - 2) : q + 3], work)
            level = min(max(means[p, q], around / guard), around * guard)
            gain[p, q] = np.float32(1.0) / level if level > np.float32(0.0) else np.float32(1.0)


@kernel
def interpolate_columns(gain: Image, before: NDArray[np.int64], share: Row, rows: Image) -> None:
    """Fill rows (beam blocks, samples) with gain (beam blocks, range blocks), interpolated along the range."""
    last = gain.shape[1] - 1
    begin = 0
    for q in range(last + 1):
        end = begin
        while end < before.size and before[end] == q:
            end += 1
        weight = share[begin:end]
        for p in range(rows.shape[0]):
            near, step = gain[p, q], gain[p, min(q + 1, last)] - gain[p, q]
            row = rows[p, begin:end]
            for j in range(row.size):
                row[j] = near + weight[j] * step
        begin = end


@kernel
def multiply_interpolated(image: Image, rows: Image, above: NDArray[np.int64], share: Row, out: Image) -> None:
    """Fill out with image (beams, samples) times rows (beam blocks, samples), interpolated from beam to beam."""
    last = rows.shape[0] - 1
    for b in range(image.shape[0]):
        source, target = image[b], out[b]
        near, far, weight = rows[above[b]], rows[min(above[b] + 1, last)], share[b]
        for j in range(source.size):
            target[j] = source[j] * (near[j] + weight * (far[j] - near[j]))
