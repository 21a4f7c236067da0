"""Samples left out by a sonar that sends only those over a threshold of its own: a clean image, but not a quiet one.

All that is below stands in the image as one and the same value, which is no level: held against it, whatever passes
the threshold is an echo, and where it is 0 there is nothing to hold anything against. So each such sample gets what may
have stood there: speckle below the threshold, as loud as the share of samples that pass the threshold says. Speckle of
mean square s^2 passes a threshold T in a share exp(-T^2 / s^2) of the samples.
"""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ods.base.arrays import AnyArray, Floats, Image
from ods.compiled import native
from ods.pipeline.image.missing.fill import DRAWN
from ods.pipeline.image.samples.amplitude import Decimation, SampleScale, mean_offset, sample_scale, to_amplitude
from ods.pipeline.image.samples.recorded import Recorded

AMPLITUDES = sample_scale(np.dtype(np.float32), "linear", 1.0)
"""The scale of a filled image."""

_SHARE = 0.25
"""Of the samples that are alike and the lowest, from which on these are taken for all that is below a threshold,"""
_STEP = 4.0
"""Least ratio of the next higher amplitude for that: counts of quiet water have neighbours."""
_BLOCK, _AROUND = 64, 4
"""Columns that have one level, and blocks to either side whose median it is."""


class ThresholdFiller:
    """Fills what is below a threshold."""

    def __init__(self) -> None:
        self._uniform = np.random.Generator(np.random.SFC64(2)).random(DRAWN, np.float32)

    def is_needed(self, recorded: Recorded, scale: SampleScale) -> bool:
        """Return whether most samples are below a threshold, judged by some of them."""
        silence = 0.0 if scale.scale == "linear" else -math.inf
        lowest = np.empty(3)
        native.lowest_samples(recorded.samples, recorded.missing, silence, lowest)
        if lowest[2] <= _SHARE:
            return False
        pair = amplitudes_of(lowest[None, :2].astype(recorded.samples.dtype), scale)[0]
        return bool(pair[0] == 0.0 or pair[1] > _STEP * pair[0])

    def filled(self, recorded: Recorded, scale: SampleScale, number: int) -> Image:
        """Return the amplitudes of all samples (beams, samples); number: of the ping."""
        image = amplitudes_of(recorded.samples, scale)
        passing, found = np.empty(-(-image.shape[1] // _BLOCK)), np.empty(2)
        native.find_threshold(image, recorded.missing, _BLOCK, passing, found)
        bottom, threshold = found.tolist()
        passing = _around(passing)
        rms = threshold / np.sqrt(-np.log(passing))
        native.fill_below(image, bottom, _BLOCK, rms, passing, self._uniform, number)
        return image


def amplitudes_of(samples: AnyArray, scale: SampleScale) -> Image:
    """Return the amplitudes of samples (beams, samples)."""
    out = np.empty(samples.shape, np.float32)
    to_amplitude(samples, Decimation(0, 1, 0, samples.shape[1]), scale, out)
    if scale.scale == "linear" and samples.dtype.kind == "u":
        out += mean_offset(1)
    return out


def _around(values: Floats) -> Floats:
    """Return the running median, in which bodies do not count."""
    padded = np.pad(values, _AROUND, mode="reflect" if values.size > _AROUND else "edge")
    return np.asarray(np.median(sliding_window_view(padded, 2 * _AROUND + 1), axis=1))
