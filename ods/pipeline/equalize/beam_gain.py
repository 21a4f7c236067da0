"""Equalization by beam: beams of different gain are brought to the same level [SSIE, Image processing, stage 1]."""

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, load_row
from ods.pipeline.stage.params import BeamGainParams
from ods.pipeline.stage.registry import gain_stage
from ods.pipeline.stage.step import GainStep

_EVERY = 16
"""Images of which one is measured."""
_PARTS = 25
_SHORTEST = 16
"""Samples of a part at least."""
_LEFT_OUT = 2
"""Lowest and highest parts of a beam that do not count,"""
_NEAR = 2
"""but so many nearest ones always do where a beam is dark."""
_HALVINGS = 14
"""Steps of the search for a median: it is known to 0.01 % of the mean."""
_LEAST = np.float32(1.06)
"""Gains of less than half a decibel are left to the other equalizers."""


@gain_stage("equalize.beam_gain", BeamGainParams)
def beam_gain(params: BeamGainParams, fan: Fan) -> GainStep:
    """Divide each beam by its gain, which is what nearly all parts of its range agree on.

    Each part's mean is compared to the median of all beams there. A beam is loud if all but two of its 25 parts are
    louder than in the typical beam, by what the least of those is; likewise dark, but then the two nearest parts must
    be dark, too. So an object counts for nothing unless it fills a beam from near to far, nor does the shadow behind
    one. Gains go up to a factor of `limit`; an image without any is passed on as it is. The first image is measured,
    every sixteenth from there on, and the first one of another type of samples.
    """
    beams, samples = fan.shape
    means = np.empty((max(1, min(_PARTS, samples // _SHORTEST)), beams), np.float32)
    gain = np.empty(beams, np.float32)
    count, differs = 0, False
    kind: np.dtype[np.generic] = np.dtype(np.void)

    def step(image: GainedImage) -> GainedImage:
        nonlocal count, differs, kind
        if count % _EVERY == 0 or image.cells.dtype != kind:
            kind = image.cells.dtype
            part_means(image, means)
            differs = gains_of_beams(means, np.float32(params.limit), gain)
        count += 1
        return image.with_beam_gain(gain) if differs else image

    return step


@kernel
def part_means(image: GainedImage, means: Image) -> None:
    """Fill means (parts, beams) with the mean of each part of the range."""
    parts, beams = means.shape
    row = np.empty(image.gain.shape[1], np.float32)
    for b in range(beams):
        load_row(image, b, row)
        for k in range(parts):
            part = row[k * row.size // parts : (k + 1) * row.size // parts]
            total = np.float32(0.0)
            for j in range(part.size):
                total += part[j]
            means[k, b] = total / np.float32(part.size)


@kernel
def gains_of_beams(means: Image, limit: np.float32, gain: Floats32) -> bool:
    """Fill gain (beams,) with what brings the beams to one level; tell whether that is to be done.

    means: (parts, beams), which become multiples of each part's median.
    """
    low, high = np.empty_like(gain), np.empty_like(gain)
    middle, spread = np.empty_like(gain), np.empty_like(gain)
    _bounds_of_levels(means, low, high)
    for b in range(gain.size):
        middle[b] = np.sqrt(low[b] * high[b])
        spread[b] = np.sqrt(high[b] / low[b]) if low[b] > np.float32(0.0) else np.float32(1.0)
    common, usual = middle_of(middle), middle_of(spread)
    least, most = np.float32(1.0), np.float32(1.0)
    for b in range(gain.size):
        level = common
        if low[b] > common:
            level = min(low[b] * usual, middle[b])
        elif np.float32(0.0) < high[b] < common:
            level = max(high[b] / usual, middle[b])
        gain[b] = np.float32(1.0)
        if level > np.float32(0.0) and common > np.float32(0.0):
            gain[b] = min(max(common / level, np.float32(1.0) / limit), limit)
        least, most = min(least, gain[b]), max(most, gain[b])
    return bool(most > _LEAST or least < np.float32(1.0) / _LEAST)


@kernel
def _bounds_of_levels(means: Image, low: Floats32, high: Floats32) -> None:
    """Fill low and high (beams,) with the least and the largest level of each beam's parts that count.

    means: (parts, beams), which become multiples of each part's median; parts of zeros are left out.
    """
    parts, beams = means.shape
    left_out = min(_LEFT_OUT, (parts - 1) // 2)
    lowest, highest = np.empty((left_out + 1, beams), np.float32), np.empty((left_out + 1, beams), np.float32)
    nearest = np.zeros(beams, np.float32)
    lowest[:], highest[:] = np.float32(np.inf), np.float32(0.0)
    for k in range(parts):
        part = means[k]
        around = middle_of(part)
        if not around > np.float32(0.0):
            continue
        for b in range(beams):
            part[b] /= around
        if k < _NEAR:
            for b in range(beams):
                nearest[b] = part[b] if part[b] > nearest[b] else nearest[b]
        _keep_extremes(part, lowest, highest)
    for b in range(beams):
        low[b] = lowest[left_out, b] if lowest[left_out, b] < np.float32(np.inf) else np.float32(0.0)
        high[b] = nearest[b] if nearest[b] > highest[left_out, b] else highest[left_out, b]


@kernel
def _keep_extremes(part: Floats32, lowest: Image, highest: Image) -> None:
    """Sort part (beams,) into the rows of the lowest, rising, and of the highest values, falling; part is lost."""
    rising, falling = part, part.copy()
    for i in range(lowest.shape[0]):
        kept, top = lowest[i], highest[i]
        for b in range(part.size):
            below, above = rising[b], kept[b]
            kept[b] = below if below < above else above
            rising[b] = above if below < above else below
        for b in range(part.size):
            below, above = top[b], falling[b]
            top[b] = above if above > below else below
            falling[b] = below if above > below else above


@kernel
def middle_of(values: Floats32) -> np.float32:
    """Return the median of values, none of them negative, by halving an interval: it is at most twice the mean."""
    total = np.float32(0.0)
    for i in range(values.size):
        total += values[i]
    low, high = np.float32(0.0), np.float32(2.0) * total / np.float32(values.size)
    half = np.float32(0.5) * np.float32(values.size)
    for _ in range(_HALVINGS):
        at, count = np.float32(0.5) * (low + high), np.float32(0.0)
        for i in range(values.size):
            count += np.float32(1.0) if values[i] > at else np.float32(0.0)
        low, high = (at, high) if count >= half else (low, at)
    return np.float32(0.5) * (low + high)
