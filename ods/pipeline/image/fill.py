"""What stands in an image where no data are, so that no stage has to know of them.

Zeros would be dark places to every equalizer and edges to every filter. So each sample without data gets what an image
without an echo would show there: mostly the mean of its neighbours along the beam where there are any, else that of
the two beams beside it, else speckle at the level of its range and its beam. Statistics of the image then stay what
they are where data are. Before an image is searched for echoes these cells are set to 0, which detection takes for no
data, so no echo is found or measured in them. Only gaps so short that they are filled by their neighbours on both sides
stay as they are filled, such as a single dead beam, which both its neighbours overlap: an echo does not fall to pieces
there.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats32, Image, Mask
from ods.compiled.kernel import kernel
from ods.pipeline.equalize.by_range import limit_levels

_NEIGHBOURS = 4
"""Samples to either side whose mean fills a gap."""
LONGEST_BRIDGED = 2 * _NEIGHBOURS
"""Gap, samples, that its neighbours fill from both sides."""
_PRIOR = np.float32(2.0)
"""The beams beside, or the level around, weigh as much as so many of them: one crest beside a gap must not be repeated
in it."""
_BEAMS = np.float32(4.0)
"""The level of the ranges around weighs as much as so many beams,"""
_COLUMNS = np.float32(64.0)
"""and that of the other beams as much as so many samples of a beam."""
_GAIN = np.float32(4.0)
"""Largest factor between beams that is believed."""
_GUARD = np.float32(1.25)
_BLOCK = 32
_REACH = 3
"""As `equalize.mean_range` limits levels: an echo in the few beams that hold data is no level."""
DRAWN = 1 << 14
"""Numbers of each kind that are drawn once; every beam of every ping begins at another place among them."""


class Drawn(NamedTuple):
    """Random numbers."""

    speckle: Floats32
    """Amplitudes of speckle of mean 1."""
    dither: Floats32
    """-1 to 1, of triangular distribution: then neither mean nor variance of the error of counting depend on the signal
    (S. P. Lipshitz, R. A. Wannamaker, J. Vanderkooy, J. Audio Eng. Soc. 40(5), 1992)."""


def draw() -> Drawn:
    """Return the numbers, always the same ones."""
    rng = np.random.Generator(np.random.SFC64(1))
    speckle = rng.rayleigh(np.sqrt(2.0 / np.pi), DRAWN)
    return Drawn(speckle.astype(np.float32), (rng.random(DRAWN) - rng.random(DRAWN)).astype(np.float32))


@kernel
def fill_gaps(image: Image, missing: Mask, drawn: Drawn, number: int) -> None:
    """Fill the missing cells of image (beams, samples), in place; number: of the ping."""
    level = np.empty(image.shape[1], np.float32)
    _levels_of_data(image, missing, level)
    held, found = np.empty(level.size + 2 * _NEIGHBOURS, np.float32), np.empty(level.size, np.float32)
    count = np.empty_like(found)
    for b in range(image.shape[0]):
        row, gaps = image[b], missing[b]
        gain = _gain_of(row, gaps, level)
        _means_around(row, gaps, held, found, count)
        begin = begin_of(number, b)
        for j in range(row.size):
            if gaps[j]:
                if is_one_beam_wide(missing, b, j):
                    prior = np.float32(0.5) * (image[b - 1, j] + image[b + 1, j])
                else:
                    prior = gain * level[j] * drawn.speckle[(begin + j) & (DRAWN - 1)]
                row[j] = (found[j] + _PRIOR * prior) / (count[j] + _PRIOR)


@kernel
def is_one_beam_wide(missing: Mask, beam: int, column: int) -> bool:
    """Tell whether the beams on both sides of a missing cell hold data there."""
    if beam == 0 or beam == missing.shape[0] - 1:
        return False
    return not missing[beam - 1, column] and not missing[beam + 1, column]


@kernel
def begin_of(number: int, beam: int) -> int:
    """Return where among the drawn numbers a beam begins: anywhere, but always the same for the same ping."""
    mixed = (number * 0x9E3779B1 + beam * 0x85EBCA77 + 0x165667B1) & 0xFFFFFFFF
    mixed = ((mixed ^ (mixed >> 15)) * 0x2C1B3C6D) & 0xFFFFFFFF
    return (mixed ^ (mixed >> 13)) & (DRAWN - 1)


@kernel
def _levels_of_data(image: Image, missing: Mask, level: Floats32) -> None:
    """Fill level (samples,) with the mean over the beams of what holds data, drawn to that of the ranges around."""
    count = np.zeros(level.size, np.float32)
    level[:] = np.float32(0.0)
    for b in range(image.shape[0]):
        row, gaps = image[b], missing[b]
        for j in range(level.size):
            held = np.float32(0.0) if gaps[j] else np.float32(1.0)
            level[j] += held * row[j]
            count[j] += held
    around = np.float32(-1.0)
    blocks = (level.size + _BLOCK - 1) // _BLOCK
    for k in range(-1, blocks):  # first, what stands before the first block that has any: that block's
        begin, stop = max(k, 0) * _BLOCK, level.size if k < 0 else min((k + 1) * _BLOCK, level.size)
        total, cells = np.float32(0.0), np.float32(0.0)
        for j in range(begin, stop):
            total += level[j]
            cells += count[j]
            if k < 0 and cells > np.float32(0.0) and j % _BLOCK == _BLOCK - 1:
                break
        around = total / cells if cells > np.float32(0.0) else around
        if k >= 0:
            for j in range(begin, stop):
                level[j] = (level[j] + _BEAMS * around) / (count[j] + _BEAMS)
    limit_levels(level, _GUARD, _REACH)


@kernel
def _gain_of(row: Floats32, gaps: Mask, level: Floats32) -> np.float32:
    """Return how much louder than the others a beam is, by what holds data of it."""
    own, others = np.float32(0.0), np.float32(0.0)
    for j in range(row.size):
        held = np.float32(0.0) if gaps[j] else np.float32(1.0)
        own += held * row[j]
        others += held * level[j]
    prior = _COLUMNS * level.mean()
    if others + prior <= np.float32(0.0):
        return np.float32(1.0)
    return min(max((own + prior) / (others + prior), np.float32(1.0) / _GAIN), _GAIN)


@kernel
def _means_around(row: Floats32, gaps: Mask, held: Floats32, found: Floats32, count: Floats32) -> None:
    """Fill found and count (samples,) with sum and number of the cells around that hold data; held: work space."""
    n = row.size
    held[:] = np.float32(0.0)
    found[:], count[:] = np.float32(0.0), np.float32(0.0)
    for j in range(n):
        held[j + _NEIGHBOURS] = np.float32(0.0) if gaps[j] else np.float32(1.0)
    for k in range(2 * _NEIGHBOURS + 1):
        part = held[k : k + n]
        for j in range(n):
            count[j] += part[j]
    for j in range(n):
        held[j + _NEIGHBOURS] *= row[j]
    for k in range(2 * _NEIGHBOURS + 1):
        part = held[k : k + n]
        for j in range(n):
            found[j] += part[j]


@kernel
def dither(image: Image, drawn: Drawn, number: int) -> None:
    """Add noise of a count to amplitudes of linear counts, in place. Some fall below 0, which keeps the mean."""
    for b in range(image.shape[0]):
        row, begin = image[b], begin_of(number, b)
        for j in range(row.size):
            row[j] += drawn.dither[(begin + j) & (DRAWN - 1)]


@kernel
def blank_gaps(image: Image, missing: Mask) -> None:
    """Set the missing cells of image (beams, samples) to 0, but for gaps that are bridged."""
    for b in range(image.shape[0]):
        row, gaps = image[b], missing[b]
        j = 0
        while j < row.size:
            stop = j
            while stop < row.size and gaps[stop]:
                stop += 1
            if stop - j > LONGEST_BRIDGED or j == 0 or stop == row.size:
                for k in range(j, stop):
                    if not is_one_beam_wide(missing, b, k):
                        row[k] = np.float32(0.0)
            j = stop + 1
