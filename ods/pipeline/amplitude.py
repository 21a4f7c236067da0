"""Recorded samples to linear amplitude.

Everything behind this module works on amplitude (proportional to sound pressure), not on intensity: the ratio of the
strongest echo to the noise stays small, the mean of a range is not ruled by one echo, and speckle, whose amplitude is
Rayleigh distributed, needs only half the smoothing that its exponentially distributed intensity does.

An integer count c stands for amplitudes from c to c + 1, so linear counts are taken as c + 1/2: a drop-out of zeros is
then a flat row, and one stray count in it is not infinitely above its surroundings.
"""

import numpy as np
from numpy.typing import NDArray

from ods.messages import Scale
from ods.pipeline.fan import Image
from ods.pipeline.kernel import kernel

MAX_AMPLITUDE = 1e15
"""Larger amplitudes are clipped, so that squares and sums of a whole image stay finite in float32."""

HALF_COUNT = np.float32(0.5)

Frame = NDArray[np.generic]
Table = NDArray[np.float32]


def amplitude_table(dtype: np.dtype[np.generic], scale: Scale, factor: float) -> Table | None:
    """Return the linear amplitude of every count, (256,) or (65536,) float32; None where no table serves.

    That is float samples, and linear counts, which are cast faster than looked up.
    """
    if dtype.kind == "f" or scale == "linear":
        return None
    counts = np.arange(2 ** (8 * dtype.itemsize), dtype=np.float64)
    return _from_log(counts, scale, factor).astype(np.float32)


def to_amplitude(frame: Frame, first: int, scale: Scale, factor: float, table: Table | None, out: Image) -> None:
    """Fill out (beams, samples) with the linear amplitude of frame[:, first : first + samples].

    frame: (beams, >= first + samples) uint8, uint16 or float32, finite; table: of `amplitude_table`. Negative float
    amplitudes become 0. scale `linear`, `db` (factor decibels a unit: 20 log10 amplitude) or `log8` (value = factor
    log10 amplitude, the rule of s7k record 7042).
    """
    if table is not None:
        _look_up(frame, first, table, out)
    elif frame.dtype.kind != "f":
        _cast(frame, first, out)
    else:
        values = frame[:, first : first + out.shape[1]].astype(np.float64)
        linear = values if scale == "linear" else _from_log(values, scale, factor)
        np.clip(linear, 0.0, MAX_AMPLITUDE, out=out, casting="same_kind")


def _from_log(values: NDArray[np.float64], scale: Scale, factor: float) -> NDArray[np.float64]:
    decades = values * factor / 20.0 if scale == "db" else values / factor
    limit = np.log10(MAX_AMPLITUDE)
    return np.asarray(10.0 ** np.clip(decades, -limit, limit))


@kernel
def _look_up(frame: Frame, first: int, table: Table, out: Image) -> None:
    for b in range(out.shape[0]):
        source = frame[b, first:]
        target = out[b]
        for j in range(target.size):
            target[j] = table[source[j]]


@kernel
def _cast(frame: Frame, first: int, out: Image) -> None:
    for b in range(out.shape[0]):
        source = frame[b, first:]
        target = out[b]
        for j in range(target.size):
            target[j] = np.float32(source[j]) + HALF_COUNT


@kernel
def average_columns(image: Image, stride: int, out: Image) -> None:
    """Fill out (beams, samples) with the means of `stride` neighbouring columns of image (beams, samples * stride)."""
    share = np.float32(1.0 / stride)
    for b in range(out.shape[0]):
        source, target = image[b], out[b]
        if stride == 2:
            for j in range(target.size):
                target[j] = share * (source[2 * j] + source[2 * j + 1])
        elif stride == 3:
            for j in range(target.size):
                target[j] = share * (source[3 * j] + source[3 * j + 1] + source[3 * j + 2])
        else:
            for j in range(target.size):
                total = np.float32(0.0)
                for k in range(stride):
                    total += source[stride * j + k]
                target[j] = share * total
