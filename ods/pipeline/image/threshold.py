"""What a sonar leaves out that tells only samples over a threshold of its own: a clean image, but not a quiet one.

All that is below stands in the image as one and the same value, which is no level: held against it, whatever passes
the threshold is an echo, and where it is 0 there is nothing to hold anything against. So each such sample gets what may
have stood there: speckle below the threshold, as loud as the share of samples that pass the threshold says. Speckle of
mean square s^2 passes a threshold T in a share exp(-T^2 / s^2) of the samples.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ods.base.arrays import AnyArray, Floats, Floats32, Image, Mask
from ods.compiled.kernel import kernel
from ods.pipeline.image.amplitude import Decimation, SampleScale, mean_offset, to_amplitude
from ods.pipeline.image.fill import DRAWN, begin_of
from ods.pipeline.image.recorded import Recorded

AMPLITUDES = SampleScale("linear", 1.0, None)
"""The scale of a filled image."""

_LOOKED_AT = 1024
_SHARE = 0.25
"""Of the samples that are alike and the lowest, from which on these are taken for all that is below a threshold,"""
_STEP = 4.0
"""if the next higher amplitude is so many times as high: counts of quiet water have neighbours."""
_FAINTEST = np.float32(1e-3)
"""Of the mean of what passes: the threshold is at least that, as images that are computed have tails without end."""
_BLOCK, _AROUND = 64, 4
"""Columns that have one level, and blocks to either side whose median it is."""
_SILENT = math.exp(-36.0)
"""Stands for no sample at all, where nobody knows how quiet it is: a sixth of the threshold."""


class Lowest(NamedTuple):
    """Of some samples."""

    value: float
    next_value: float
    """The same where there is no other."""
    share: float
    """That have the lowest value."""


class ThresholdFiller:
    """Fills what is below a threshold."""

    def __init__(self) -> None:
        self._uniform = np.random.Generator(np.random.SFC64(2)).random(DRAWN, np.float32)

    def is_needed(self, recorded: Recorded, scale: SampleScale) -> bool:
        """Tell, by some of the samples, whether most are below a threshold."""
        silence = 0.0 if scale.scale == "linear" else -math.inf
        lowest, higher, share = _lowest(recorded.samples, recorded.missing, silence)
        if share <= _SHARE:
            return False
        pair = amplitudes_of(np.array([[lowest, higher]]).astype(recorded.samples.dtype), scale)[0]
        return bool(pair[0] == 0.0 or pair[1] > _STEP * pair[0])

    def filled(self, recorded: Recorded, scale: SampleScale, number: int) -> Image:
        """Return the amplitudes of all samples (beams, samples); number: of the ping."""
        image = amplitudes_of(recorded.samples, scale)
        bottom = image.min()
        passing = _around(_passing(image, recorded.missing, bottom))
        rms = _threshold(image, bottom) / np.sqrt(-np.log(passing))
        _fill(image, bottom, (rms, passing), self._uniform, number)
        return image


def amplitudes_of(samples: AnyArray, scale: SampleScale) -> Image:
    """Return the amplitudes of samples (beams, samples)."""
    out = np.empty(samples.shape, np.float32)
    to_amplitude(samples, Decimation(0, 1, 0, samples.shape[1]), scale, out)
    if scale.scale == "linear" and samples.dtype.kind == "u":
        out += mean_offset(1)
    return out


@kernel
def _lowest(samples: AnyArray, missing: Mask, silence: float) -> Lowest:
    """Look at some samples that hold data, evenly spread; what is below `silence` counts as that."""
    step = max(1, samples.size // _LOOKED_AT) | 1  # odd: so that it falls in with no rows
    value, higher, alike, looked, j = np.inf, np.inf, 0, 0, 0
    for b in range(samples.shape[0]):
        row = samples[b]
        while j < row.size:
            if missing.size == 0 or not missing[b, j]:
                sample = max(float(row[j]), silence)
                looked += 1
                if sample < value:
                    value, higher, alike = sample, value, 1
                elif sample == value:
                    alike += 1
                else:
                    higher = min(higher, sample)
            j += step
        j -= row.size
    if looked == 0:
        return Lowest(0.0, 0.0, 0.0)
    return Lowest(value, higher if higher < np.inf else value, alike / looked)


@kernel
def _passing(image: Image, missing: Mask, bottom: np.float32) -> Floats:
    """Return the share of samples over the bottom in each block of columns, (blocks,), less than 1; `_SILENT`: none."""
    out = np.empty((image.shape[1] + _BLOCK - 1) // _BLOCK)
    for k in range(out.size):
        over, looked = 0, 0
        for b in range(image.shape[0]):
            for j in range(k * _BLOCK, min((k + 1) * _BLOCK, image.shape[1])):
                if missing.size == 0 or not missing[b, j]:
                    looked += 1
                    over += image[b, j] > bottom
        out[k] = over / (looked + 1.0) if over > 0 else _SILENT
    return out


def _around(values: Floats) -> Floats:
    """Return the running median, in which bodies do not count."""
    padded = np.pad(values, _AROUND, mode="reflect" if values.size > _AROUND else "edge")
    return np.asarray(np.median(sliding_window_view(padded, 2 * _AROUND + 1), axis=1))


@kernel
def _fill(image: Image, bottom: np.float32, rms: tuple[Floats, Floats], uniform: Floats32, number: int) -> None:
    """Draw what is lowest in image (beams, samples) anew, in place.

    rms: of each block, and what passes there, (blocks,) each.
    """
    for b in range(image.shape[0]):
        first = begin_of(number, b)
        for j in range(image.shape[1]):
            if image[b, j] <= bottom:
                drawn, block = uniform[(first + j) & (DRAWN - 1)], j // _BLOCK
                image[b, j] = rms[0][block] * math.sqrt(-math.log(1.0 - drawn * (1.0 - rms[1][block])))


@kernel
def _threshold(image: Image, bottom: np.float32) -> np.float32:
    """Return the lowest amplitude over the bottom; 0 where there is none."""
    lowest, total, count = np.float32(np.inf), 0.0, 0
    for b in range(image.shape[0]):
        for value in image[b]:
            if value > bottom:
                lowest = min(lowest, value)
                total += value
                count += 1
    if count == 0:
        return np.float32(0.0)
    return max(lowest, np.float32(_FAINTEST * total / count))
