"""Samples that hold no data: those that the decoder reported, and those recognized by their values."""

import math
from enum import IntFlag, auto

import numpy as np

from ods.base.arrays import AnyArray, Indices, Mask
from ods.compiled import native
from ods.messages import Ping

ALL_DATA: Mask = np.zeros((0, 0), np.bool_)
"""Stands for a mask (beams, samples) in which nothing is marked."""

_LOUD_RATIO = 4.0
"""Mean amplitude of a block that is clearly above the lowest count: of speckle there, 5 % are 0."""
PROBED = 4
"""Samples of each beam by which most are known not to be alike."""


class _Zeros(IntFlag):
    """Zeros that are no data, as no_data.c says."""

    AT_ENDS = auto()
    STREWN_ABOUT = auto()


def samples_without_data(ping: Ping, frame: AnyArray, first: int, top: float) -> Mask:
    """Return which samples, of frame (beams, samples) from column `first` on, hold no data; `ALL_DATA` if all do.

    top: full scale.
    """
    found = _found(ping, frame, first, top)
    if not ping.no_data:
        return found
    mask = found if found.size else np.zeros(frame.shape, np.bool_)
    for beam, begin, stop in ping.no_data:
        mask[beam, begin:stop] = True
    return mask


def _found(ping: Ping, frame: AnyArray, first: int, top: float) -> Mask:
    """Return what the samples themselves say."""
    stuck = _stuck_beams(frame, first, top)
    starts = np.empty(len(frame), np.int64)
    # logarithms of floats have no value that stands for silence
    silence = ping.dtype != "f4" or ping.scale == "linear"
    found = native.find_gaps(frame, first, _loud_count(ping), starts) if silence else 0
    if not found and not stuck.size:
        return ALL_DATA
    mask = np.zeros(frame.shape, np.bool_)
    mask[stuck] = True
    if found & _Zeros.STREWN_ABOUT:
        np.equal(frame[:, first:], 0, out=mask[:, first:])
    if found & _Zeros.AT_ENDS:
        for row, start in zip(mask, starts.tolist(), strict=True):
            row[start:] = True
    return mask


def _stuck_beams(frame: AnyArray, first: int, top: float) -> Indices:
    """Return the beams that show one value all along, where it is not the image's lowest, which may be silence, nor
    full scale, which is saturation."""
    value = frame[:, first]
    few = frame[:, first :: max(1, (frame.shape[1] - first) // PROBED)]
    rows = np.flatnonzero((few == value[:, None]).all(axis=1) & (value != top))
    if not rows.size:
        return rows
    alike: Mask = (frame[rows, first:] == value[rows, None]).all(axis=1) & (value[rows] > frame[:, first:].min())
    return np.asarray(rows[alike])


def _loud_count(ping: Ping) -> float:
    """Return the count that stands for `_LOUD_RATIO` times the lowest amplitude; 0 where amplitudes are not counted."""
    if ping.dtype == "f4":
        return 0.0
    if ping.scale == "linear":
        return _LOUD_RATIO
    decades = math.log10(_LOUD_RATIO)
    return ping.scale_factor * decades if ping.scale == "log8" else 20.0 * decades / ping.scale_factor
