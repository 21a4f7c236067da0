"""Recorded samples to linear amplitude.

Everything behind this module works on amplitude (proportional to sound pressure), not on intensity: the ratio of the
strongest echo to the noise stays small, the mean of a range is not ruled by one echo, and speckle, whose amplitude is
Rayleigh distributed, needs only half the smoothing that its exponentially distributed intensity does.

An integer count c stands for amplitudes from c to c + 1, so linear counts are taken as c + 1/2: a drop-out of zeros is
then a flat row, and one stray count in it is not infinitely above its surroundings.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats, Floats32, Image
from ods.compiled import native
from ods.messages import Scale

MAX_AMPLITUDE = 1e15
"""Larger amplitudes are clipped, so that squares and sums of a whole image stay finite in float32."""


class SampleScale(NamedTuple):
    """Conversion of recorded samples to linear amplitude."""

    scale: Scale
    """`linear`, `db` (factor decibels a unit: 20 log10 amplitude) or `log8` (value = factor log10 amplitude, the rule
    of s7k record 7042)."""
    factor: float
    table: Floats32
    """(256,) or (65536,) linear amplitude of each count that is not linear; (0,) where samples are not such counts."""
    top: float
    """Full scale: the highest sample of the type."""
    db_a_count: float
    """What a count is worth where counts are logarithms, dB; 0 where they are not."""


class Decimation(NamedTuple):
    """Columns of an image that are made of a frame's: each of `stride` neighbouring ones, from `first` on."""

    first: int
    stride: int
    begin: int
    """Columns of the image, from here"""
    end: int
    """to before here."""


def sample_scale(dtype: np.dtype[Any], scale: Scale, factor: float) -> SampleScale:
    """Return how samples of a type become amplitudes; float samples and linear counts need no table."""
    db_a_count = 0.0 if scale == "linear" else 20.0 / factor if scale == "log8" else factor
    table = np.zeros(0, np.float32)
    if dtype.kind == "u" and scale != "linear":
        counts = np.arange(2 ** (8 * dtype.itemsize), dtype=np.float64)
        table = _from_log(counts, scale, factor).astype(np.float32)
    top = float(np.iinfo(dtype).max) if dtype.kind == "u" else math.inf
    return SampleScale(scale, factor, table, top, db_a_count)


def to_amplitude(frame: AnyArray, columns: Decimation, scale: SampleScale, out: Image) -> None:
    """Fill columns of out with the mean linear amplitude of those of frame, (beams, samples).

    frame: finite float32, or counts whose amplitudes `scale` has a table of. Negative float amplitudes become 0.
    """
    if scale.table.size or scale.scale == "linear":
        native.mean_amplitudes(frame, columns, scale.table, MAX_AMPLITUDE, out)
    else:
        first, stride, begin, end = columns
        values = frame[:, first : first + (end - begin) * stride].astype(np.float64)
        linear = _from_log(values, scale.scale, scale.factor)
        out[:, begin:end] = linear.reshape(len(out), end - begin, stride).mean(axis=2)


def _from_log(values: Floats, scale: Scale, factor: float) -> Floats:
    with np.errstate(over="ignore"):  # what a tiny or huge factor carries beyond all numbers is clipped below
        decades = values * factor / 20.0 if scale == "db" else values / factor
    limit = np.log10(MAX_AMPLITUDE)
    return np.asarray(10.0 ** np.clip(decades, -limit, limit))


def mean_offset(stride: int) -> np.float32:
    """Return what makes amplitudes of rounded-down means of counts: half a count, and what rounding takes."""
    return np.float32(0.5 + 0.5 * (stride - 1) / stride)
