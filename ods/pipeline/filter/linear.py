"""Linear filters `fir`, `box` and `gaussian`, along the beam or along and across [SSIE, Image processing, stage 2]."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.stage.params import BoxParams, FirParams, GaussianParams
from ods.pipeline.stage.registry import gained_image_stage
from ods.pipeline.stage.step import GainedImageStep

_LEAST_SIGMA = 0.3
"""Beams; less of it changes nothing that is worth the time."""


@gained_image_stage("filter.fir", FirParams)
def fir(params: FirParams, fan: Fan) -> GainedImageStep:
    """Low-pass filter of odd length and linear phase; designed from a cut-off or from a minimum object size."""
    taps, cutoff = params.taps, params.cutoff
    if params.object_m > 0.0:
        cutoff = min(fan.dr_m / params.object_m, 0.9)
        taps = min(2 * round(params.object_m / fan.dr_m) + 1, 99)
    along, across = lowpass_weights(taps, cutoff), lowpass_weights(params.beams, params.beam_cutoff)
    return separable(along, across if params.beams > 1 else round_weights(along, params.round_beams, fan))


@gained_image_stage("filter.box", BoxParams)
def moving_average(params: BoxParams, fan: Fan) -> GainedImageStep:
    """Moving average: of all filters of its length the one that takes out most of the speckle."""
    return separable(box_weights(params.window), box_weights(params.beams))


@gained_image_stage("filter.gaussian", GaussianParams)
def gaussian(params: GaussianParams, fan: Fan) -> GainedImageStep:
    """Gaussian weights, cut at three standard deviations."""
    return separable(gaussian_weights(params.sigma), gaussian_weights(params.beam_sigma))


class SeparableFilter(NamedTuple):
    """A separable symmetric filter: weights from the middle outwards, of sum 1 with their mirror image."""

    along: Floats32
    """(half + 1,) weights along the range."""
    across: Floats32
    """(reach + 1,) weights from beam to beam."""


def separable(along: Floats32, across: Floats32) -> GainedImageStep:
    """Return the step of a filter with weights `along` the range and `across` the beams, in `lowpass_weights`' form."""
    weights = SeparableFilter(along, across)

    def step(image: GainedImage, out: Image) -> None:
        native.filter_plane(image, weights, out)

    return step


def round_weights(along: Floats32, limit: float, fan: Fan) -> Floats32:
    """Return weights across the beams that smooth as far, at half range, as `along` does along them.

    limit: largest standard deviation, beams. A lone weight where that is less than `_LEAST_SIGMA`: no filter. What is
    steep enough to overshoot has a second moment below 0: it does not smooth.
    """
    second_moment = 2.0 * float((along * np.arange(along.size) ** 2).sum())
    spread_m = fan.dr_m * float(np.sqrt(max(0.0, second_moment)))
    middle_m = 0.5 * (float(fan.range_m[-1]) + fan.dr_m + fan.range0_m)
    spacing_m = middle_m * float(np.median(np.diff(fan.bearing_rad))) if len(fan.bearing_rad) > 1 else np.inf
    sigma = min(limit, spread_m / spacing_m)
    return gaussian_weights(sigma if sigma >= _LEAST_SIGMA else 0.0)


def box_weights(window: int) -> Floats32:
    """Return the weights of a moving average, (window // 2 + 1,), in the form of `lowpass_weights`; window odd."""
    return np.full(window // 2 + 1, 1.0 / window, np.float32)


def gaussian_weights(sigma: float) -> Floats32:
    """Return Gaussian weights of standard deviation sigma, cells, in the form of `lowpass_weights`; 0: no filter."""
    offset = np.arange(int(np.ceil(3.0 * sigma)) + 1)
    half = np.exp(-0.5 * (offset / max(sigma, 1e-6)) ** 2)
    return np.asarray(half / (2.0 * half.sum() - half[0]), np.float32)


def lowpass_weights(taps: int, cutoff: float) -> Floats32:
    """Return the middle weight and those to its right, (taps // 2 + 1,), of a Hamming-windowed sinc of unit gain.

    taps: odd; cutoff: fraction of the Nyquist frequency. The other half mirrors this one.
    """
    offset = np.arange(taps // 2 + 1)
    window = 0.54 + 0.46 * np.cos(2.0 * np.pi * offset / max(1, taps - 1))
    half = np.sinc(cutoff * offset) * window
    return np.asarray(half / (2.0 * half.sum() - half[0]), np.float32)
