"""Recorded samples to linear amplitude.

Everything behind this module works on amplitude (proportional to sound pressure), not on intensity: the ratio of the
strongest echo to the noise stays small, the mean of a range is not ruled by one echo, and speckle, whose amplitude is
Rayleigh distributed, needs only half the smoothing that its exponentially distributed intensity does.

An integer count c stands for amplitudes from c to c + 1, so linear counts are taken as c + 1/2: a drop-out of zeros is
then a flat row, and one stray count in it is not infinitely above its surroundings.
"""

import numpy as np

from ods.base.arrays import AnyArray, Floats, Floats32, Image
from ods.base.kernel import kernel
from ods.messages import Scale

MAX_AMPLITUDE = 1e15
"""Larger amplitudes are clipped, so that squares and sums of a whole image stay finite in float32."""

Frame = AnyArray
Table = Floats32


def amplitude_table(dtype: np.dtype[np.generic], scale: Scale, factor: float) -> Table | None:
    """Return the linear amplitude of every count, (256,) or (65536,) float32; None where no table serves.

    That is float samples, and linear counts, which need none.
    """
    if dtype.kind == "f" or scale == "linear":
        return None
    counts = np.arange(2 ** (8 * dtype.itemsize), dtype=np.float64)
    return _from_log(counts, scale, factor).astype(np.float32)


def to_amplitude(
    frame: Frame, first: int, stride: int, scale: Scale, factor: float, table: Table | None, out: Image, columns: slice
) -> None:
    """Fill out[:, columns] with the linear amplitude of frame, each column the mean of `stride` of the frame's.

    frame: (beams, samples) of finite float32, or of counts whose amplitudes `table` has, as `amplitude_table` makes it;
    columns `first` to `first + stride - 1` make the first one of `columns`. Negative float amplitudes become 0. scale
    `linear`, `db` (factor decibels a unit: 20 log10 amplitude) or `log8` (value = factor log10 amplitude, the rule of
    s7k record 7042).
    """
    if table is not None:
        _look_up(frame, first, stride, table, out, columns.start, columns.stop)
    else:
        count = columns.stop - columns.start
        values = frame[:, first : first + count * stride].astype(np.float64)
        linear = np.clip(values if scale == "linear" else _from_log(values, scale, factor), 0.0, MAX_AMPLITUDE)
        out[:, columns] = linear.reshape(len(out), count, stride).mean(axis=2)


def _from_log(values: Floats, scale: Scale, factor: float) -> Floats:
    decades = values * factor / 20.0 if scale == "db" else values / factor
    limit = np.log10(MAX_AMPLITUDE)
    return np.asarray(10.0 ** np.clip(decades, -limit, limit))


@kernel
def _look_up(frame: Frame, first: int, stride: int, table: Table, out: Image, begin: int, stop: int) -> None:
    share = np.float32(1.0 / stride)
    for b in range(out.shape[0]):
        source, target = frame[b, first:], out[b, begin:stop]
        if stride == 1:
            for j in range(target.size):
                target[j] = table[source[j]]
        elif stride == 2:
            for j in range(target.size):
                target[j] = share * (table[source[2 * j]] + table[source[2 * j + 1]])
        else:
            for j in range(target.size):
                total = np.float32(0.0)
                for k in range(stride):
                    total += table[source[stride * j + k]]
                target[j] = share * total


@kernel
def average_counts(frame: Frame, first: int, stride: int, out: Frame, begin: int, stop: int) -> None:
    """Fill out[:, begin:stop] with the means of `stride` neighbouring counts of frame, rounded down; both unsigned.

    Column `first` of frame is the first that counts. `mean_offset` is what is to be added.
    """
    share = np.float32(1.0 / stride)
    for b in range(out.shape[0]):
        source, target = frame[b, first:], out[b, begin:stop]
        if stride == 1:
            for j in range(target.size):
                target[j] = source[j]
        elif stride == 2:  # by itself, as a fixed stride vectorises
            for j in range(target.size):
                target[j] = (np.uint32(source[2 * j]) + np.uint32(source[2 * j + 1])) >> np.uint32(1)
        else:
            for j in range(target.size):
                total = np.float32(0.5)  # clear of whole numbers: rounding never takes it below one
                for k in range(stride):
                    total += np.float32(source[stride * j + k])
                target[j] = np.uint32(total * share)


def mean_offset(stride: int) -> np.float32:
    """Return what makes amplitudes of `average_counts`: half a count, and what rounding down takes on average."""
    return np.float32(0.5 + 0.5 * (stride - 1) / stride)
