"""Equalization by place: the mean around each place is brought to 1."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats32, Image, Ints
from ods.compiled.kernel import kernel
from ods.pipeline.equalize.by_range import sorted_middle
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, load_row
from ods.pipeline.stage.params import LocalParams
from ods.pipeline.stage.registry import gain_stage
from ods.pipeline.stage.step import GainStep

_BESIDE = np.float32(1.4)
"""A block is raised by so many times more than those beside it, at most: what is darker is a shadow."""


@gain_stage("equalize.local", LocalParams)
def local(params: LocalParams, fan: Fan) -> GainStep:
    """Divide by the mean around each place: levels out beams of different gain and slow changes along the beams.

    The fan is parted into blocks; their means, interpolated in between, are the level. A block counts as within a
    factor of `guard` of its surroundings along the range, so that an object, however wide, does not erase itself. What
    is in the shadow of a wall stays dark beside what is lit: else the lit bottom within a block of it would be raised.
    """
    beams, samples = fan.shape
    beam_edges = np.linspace(0, beams, min(params.beam_blocks, beams) + 1).astype(np.int64)
    range_edges = np.linspace(0, samples, min(params.range_blocks, samples) + 1).astype(np.int64)
    above, share_of_beam = _between(beam_edges)
    blocks = Blocks(beam_edges, range_edges, *_between(range_edges), np.float32(params.guard))
    rows = np.empty((beam_edges.size - 1, samples), np.float32)

    def step(image: GainedImage) -> GainedImage:
        local_gain(image, blocks, rows)
        return image.with_gain(rows, above, share_of_beam)

    return step


class Blocks(NamedTuple):
    """How the fan is parted."""

    beam_edges: Ints
    """(beam blocks + 1,) first beam of each block, and the number of beams."""
    range_edges: Ints
    """(range blocks + 1,) first column of each block, and the number of columns."""
    before: Ints
    """(samples,) the last block whose middle is not behind the column,"""
    share: Floats32
    """(samples,) and how far the column is on the way to the next one's."""
    guard: np.float32


def _between(edges: Ints) -> tuple[Ints, Floats32]:
    """Return, for each cell, the last block whose middle is not behind it and how far it is on the way to the next."""
    middle = 0.5 * (edges[1:] + edges[:-1] - 1)
    place = np.interp(np.arange(edges[-1]), middle, np.arange(len(middle)))
    block = np.minimum(place.astype(np.int64), max(0, len(middle) - 2))
    return block, (place - block).astype(np.float32)


@kernel
def local_gain(image: GainedImage, blocks: Blocks, rows: Image) -> None:
    """Fill rows (beam blocks, samples) with the gain that brings the image's mean around each place to 1."""
    means = np.empty((blocks.beam_edges.size - 1, blocks.range_edges.size - 1), np.float32)
    gain = np.empty_like(means)
    block_means(image, blocks.beam_edges, blocks.range_edges, means)
    block_gains(means, blocks.guard, gain)
    interpolate_columns(gain, blocks.before, blocks.share, image.gain[0], rows)


@kernel
def block_means(image: GainedImage, beam_edges: Ints, range_edges: Ints, means: Image) -> None:
    """Fill means (beam blocks, range blocks) with the mean of the image over each block."""
    row = np.empty(range_edges[-1], np.float32)
    for p in range(means.shape[0]):
        means[p, :] = np.float32(0.0)
        for b in range(beam_edges[p], beam_edges[p + 1]):
            load_row(image, b, row)
            for q in range(means.shape[1]):
                part = row[range_edges[q] : range_edges[q + 1]]
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
            gain[p, q] = np.float32(1.0) / level if level > np.float32(0.0) else np.float32(np.inf)
    for q in range(means.shape[1]):
        keep_shadows_dark(gain[:, q])


@kernel
def keep_shadows_dark(gain: Floats32) -> None:
    """Limit gain (beam blocks,) to `_BESIDE` times the lower of those beside each, in place; infinite ones to 1."""
    before = gain.copy()
    for p in range(gain.size):
        for beside in (max(0, p - 1), min(p + 1, gain.size - 1)):
            gain[p] = min(gain[p], _BESIDE * before[beside])
        gain[p] = gain[p] if gain[p] < np.float32(np.inf) else np.float32(1.0)


@kernel
def interpolate_columns(gain: Image, before: Ints, share: Floats32, others: Floats32, rows: Image) -> None:
    """Fill rows (beam blocks, samples) with gain (beam blocks, range blocks), interpolated along the range.

    It is multiplied by `others` (samples,), the gain that the samples have already.
    """
    last = gain.shape[1] - 1
    begin = 0
    for q in range(last + 1):
        end = begin
        while end < before.size and before[end] == q:
            end += 1
        weight, other = share[begin:end], others[begin:end]
        for p in range(rows.shape[0]):
            near, step = gain[p, q], gain[p, min(q + 1, last)] - gain[p, q]
            row = rows[p, begin:end]
            for j in range(row.size):
                row[j] = (near + weight[j] * step) * other[j]
        begin = end
