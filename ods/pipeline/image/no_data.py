"""Samples that hold no data: what the decoder told of them, and what can be seen in the samples themselves.

A beam that is cut short is padded with zeros, and a dead one is all zeros. Zeros are data, too, where the water is so
quiet that most samples are less than one count. So zeros up to a beam's end count as no data only where the beam was
loud just before, or where the other beams are not silent at those ranges. Zeros strewn over a loud image hold no data
either: speckle is hardly ever that dark.
"""

import math

import numpy as np

from ods.base.arrays import AnyArray, Floats32, Ints, Mask
from ods.compiled.kernel import kernel
from ods.messages import Ping

ALL_DATA: Mask = np.zeros((0, 0), np.bool_)
"""Stands for a mask (beams, samples) in which nothing is marked."""

_TAIL = 16
"""Samples at a beam's end that are zero before it is looked at."""
_BLOCK = 32
"""Samples that are judged together."""
_LOUD = 0.5
"""A block of a beam is loud where no more than this share of it is zero."""
_BEFORE = 8
"""Blocks before a run of zeros of which three in four have to be loud."""
_STREWN_PROBE = 1024
"""Samples looked at for zeros in their midst,"""
_STREWN = 0.03
"""and the share of them from which on the image is looked at as a whole."""
_LOUD_RATIO = 4.0
"""Mean amplitude of a block that is clearly above the lowest count: of speckle there, 5 % are 0,"""
_FEWEST = 6
"""and by so many samples at least it is known."""
_FAINT, _FAINT_SHARE = 0.25, 0.01
"""Of the mean amplitude of the samples that are not zero, and the share of them that is as faint: of speckle, 5 %.
Where none is, zeros stand for what is below a threshold of the sonar's (threshold.py)."""
_EVIDENCE = 12.0
"""Logarithm of how improbable zeros have to be where other beams are not silent; each block counts for 1 at most."""


class NoDataError(ValueError):
    """The ping marks samples that it does not have."""


def samples_without_data(ping: Ping, frame: AnyArray, first: int) -> Mask:
    """Return which samples, of frame (beams, samples) from column `first` on, hold no data; `ALL_DATA` if all do.

    Raises NoDataError.
    """
    found = _found(ping, frame, first)
    if not ping.no_data:
        return found
    mask = found if found.size else np.zeros(frame.shape, np.bool_)
    for beam, begin, stop in ping.no_data:
        if not (0 <= beam < ping.beams and 0 <= begin < stop <= ping.samples):
            raise NoDataError(f"no_data: there are no samples {begin} to {stop} of beam {beam}")
        mask[beam, begin:stop] = True
    return mask


def _found(ping: Ping, frame: AnyArray, first: int) -> Mask:
    """Return what the samples themselves say. Logarithms of floats have no value that stands for silence."""
    if ping.dtype == "f4" and ping.scale != "linear":
        return ALL_DATA
    mask = ALL_DATA
    if _any_silent_tail(frame, first):
        starts = _starts_of_gaps(frame, first)
        if (starts < frame.shape[1]).any():
            mask = np.arange(frame.shape[1]) >= starts[:, None]
    if share_of_zeros(frame, first, _STREWN_PROBE) > _STREWN and _is_strewn(frame, first, _loud_count(ping)):
        mask = np.zeros(frame.shape, np.bool_) if not mask.size else mask
        mask[:, first:] |= frame[:, first:] == 0
    return mask


def _loud_count(ping: Ping) -> float:
    """Return the count that stands for `_LOUD_RATIO` times the lowest amplitude; 0 where amplitudes are not counted."""
    if ping.dtype == "f4":
        return 0.0
    decades = math.log10(_LOUD_RATIO)
    return {"linear": _LOUD_RATIO, "log8": ping.scale_factor * decades, "db": 20.0 * decades / ping.scale_factor}[
        ping.scale
    ]


@kernel
def share_of_zeros(frame: AnyArray, first: int, count: int) -> float:
    """Return the share of zeros among about `count` samples of frame (beams, samples) from column `first` on."""
    beams = frame.shape[0]
    step = max(1, beams * (frame.shape[1] - first) // count) | 1  # odd: so that it falls in with no rows
    looked, zeros, j = 0, 0, 0
    for b in range(beams):
        row = frame[b, first:]
        while j < row.size:
            looked += 1
            zeros += 1 if row[j] == 0 else 0
            j += step
        j -= row.size
    return zeros / max(looked, 1)


@kernel
def _is_strewn(frame: AnyArray, first: int, loud: float) -> bool:
    """Tell whether a quarter of all blocks are loud, and most of those have several zeros, but faint samples, too."""
    blocks, loud_ones, strewn, faint, others = 0, 0, 0, 0, 0
    for b in range(frame.shape[0]):
        row = frame[b, first:]
        for begin in range(0, row.size - _BLOCK + 1, _BLOCK):
            part = row[begin : begin + _BLOCK]
            total, count = np.float32(0.0), 0
            for j in range(_BLOCK):
                total += np.float32(part[j])
                count += 0 if part[j] == 0 else 1
            blocks += 1
            is_loud = count >= _FEWEST and total >= np.float32(loud) * np.float32(count)
            loud_ones += 1 if is_loud else 0
            if is_loud and _BLOCK - count >= 3:
                strewn += 1
                others += count
                least = np.float32(_FAINT) * total / np.float32(count)
                for j in range(_BLOCK):
                    faint += 1 if 0 < np.float32(part[j]) <= least else 0
    return 4 * loud_ones >= blocks > 0 and 2 * strewn > loud_ones and faint > _FAINT_SHARE * others


@kernel
def _any_silent_tail(frame: AnyArray, first: int) -> bool:
    """Tell whether any beam ends in zeros."""
    begin = max(first, frame.shape[1] - _TAIL)
    for b in range(frame.shape[0]):
        row = frame[b]
        silent = True
        for j in range(begin, row.size):
            silent = silent and row[j] == 0
        if silent:
            return True
    return False


@kernel
def _starts_of_gaps(frame: AnyArray, first: int) -> Ints:
    """Return, (beams,), the column from which on each beam holds no data; the number of columns where it is whole."""
    beams, samples = frame.shape
    blocks = (samples - first + _BLOCK - 1) // _BLOCK
    zeros = np.zeros((beams, blocks), np.float32)
    tail, silent = np.empty(beams, np.int64), np.zeros(blocks, np.float32)
    for b in range(beams):
        tail[b] = _count_zeros(frame[b, first:], zeros[b])
        for k in range(blocks):
            silent[k] += zeros[b, k] / np.float32(beams)
    starts = np.full(beams, samples)
    for b in range(beams):
        long_enough = samples - first - tail[b] >= _TAIL
        if long_enough and (_was_loud(zeros[b], tail[b]) or _is_improbable(silent, tail[b])):
            starts[b] = first + tail[b]
    return starts


@kernel
def _count_zeros(row: AnyArray, zeros: Floats32) -> int:
    """Fill zeros (blocks,) with the share of zeros of each block of the row; return where those at its end begin."""
    tail = row.size
    while tail > 0 and row[tail - 1] == 0:
        tail -= 1
    for k in range(zeros.size):
        part = row[k * _BLOCK : (k + 1) * _BLOCK]
        count = 0
        for j in range(part.size):
            count += 1 if part[j] == 0 else 0
        zeros[k] = np.float32(count) / np.float32(part.size)
    return tail


@kernel
def _was_loud(zeros: Floats32, tail: int) -> bool:
    """Tell whether a beam was loud before the zeros at its end."""
    last = tail // _BLOCK
    begin = max(0, last - _BEFORE)
    loud = 0
    for k in range(begin, last):
        loud += 1 if zeros[k] <= _LOUD else 0
    return last > begin and 4 * loud >= 3 * (last - begin)


@kernel
def _is_improbable(silent: Floats32, tail: int) -> bool:
    """Tell whether zeros from `tail` on are no chance, as often as all beams are zero there."""
    begin = (tail + _BLOCK - 1) // _BLOCK
    evidence = 0.0
    for k in range(begin, silent.size):
        evidence += min(1.0, -_BLOCK * np.log(max(silent[k], np.float32(1e-6))))
    return evidence >= max(_EVIDENCE, 0.5 * (silent.size - begin))
