"""Linear filters `fir`, `box` and `gaussian`, along the beam or along and across [SSIE, Image processing, stage 2].

The image is mirrored at the range ends and at the fan's edges. All filters are symmetric: echoes keep their place.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, load_mirrored
from ods.pipeline.image.padding import mirrored
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
    return separable(along, across if params.beams > 1 else round_weights(along, params.round_beams, fan), fan)


@gained_image_stage("filter.box", BoxParams)
def moving_average(params: BoxParams, fan: Fan) -> GainedImageStep:
    """Moving average: of all filters of its length the one that takes out most of the speckle."""
    return separable(box_weights(params.window), box_weights(params.beams), fan)


@gained_image_stage("filter.gaussian", GaussianParams)
def gaussian(params: GaussianParams, fan: Fan) -> GainedImageStep:
    """Gaussian weights, cut at three standard deviations."""
    return separable(gaussian_weights(params.sigma), gaussian_weights(params.beam_sigma), fan)


class SeparableFilter(NamedTuple):
    """A separable symmetric filter: weights from the middle outwards, of sum 1 with their mirror image; work space."""

    along: Floats32
    """(half + 1,) weights along the range."""
    across: Floats32
    """(reach + 1,) weights from beam to beam."""
    padded: Floats32
    """(at least samples + 2 half,)."""
    sums: Floats32
    """As large."""
    ring: Image
    """(2 reach + 1, samples), the rows around the present one, filtered in range."""


def separable_filter(along: Floats32, across: Floats32, samples: int) -> SeparableFilter:
    """Return the filter with these weights for images of so many range samples."""
    padded = np.empty((2, samples + 2 * along.size), np.float32)
    return SeparableFilter(along, across, padded[0], padded[1], np.empty((2 * across.size - 1, samples), np.float32))


def separable(along: Floats32, across: Floats32, fan: Fan) -> GainedImageStep:
    """Return the step of a filter with weights `along` the range and `across` the beams, in `lowpass_weights`' form."""
    weights = separable_filter(along, across, fan.samples)

    def step(image: GainedImage, out: Image) -> None:
        filter_plane(image, weights, out)

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


@kernel
def filter_plane(image: GainedImage, weights: SeparableFilter, out: Image) -> None:
    """Fill out (beams, samples) with image convolved along the range and from beam to beam."""
    along, across, padded, sums, ring = weights
    half, reach = along.size - 1, across.size - 1
    beams = out.shape[0]
    for b in range(-reach, beams + reach):
        load_mirrored(image, mirrored(b, beams), half, padded)
        symmetric_row(padded, along, sums, ring[(b + reach) % ring.shape[0]] if reach else out[b])
        if b >= reach > 0:
            weigh_ring(ring, across, b, out[b - reach])


@kernel
def weigh_ring(ring: Image, weights: Floats32, middle: int, target: Floats32) -> None:
    """Fill target with the weighted sum of a ring's rows: weights (reach + 1,) from row `middle` (modulo) outwards."""
    count = ring.shape[0]
    weight, row = weights[0], ring[middle % count]
    for j in range(target.size):
        target[j] = weight * row[j]
    for k in range(1, weights.size):
        weight, left, right = weights[k], ring[(middle + count - k) % count], ring[(middle + k) % count]
        for j in range(target.size):
            target[j] += weight * (left[j] + right[j])


@kernel
def symmetric_row(padded: Floats32, weights: Floats32, sums: Floats32, target: Floats32) -> None:
    """Convolve one mirrored row: padded (samples + 2 half,), weights (half + 1,), target (samples,).

    sums: work space as large as padded.
    """
    samples = target.size
    half = weights.size - 1
    if half == 4 and weights[0] == weights[4]:
        _mean_of_9(padded, sums, target)
        return
    if half == 4:
        _row_of_9(padded, weights, target)
        return
    weight = weights[0]
    middle = padded[half : half + samples]
    for j in range(samples):
        target[j] = weight * middle[j]
    # two pairs of taps a pass: fewer passes mean less memory traffic, more pairs keep the compiler from vectorising
    for k in range(1, half, 2):
        near, far = weights[k], weights[k + 1]
        left, right = padded[half - k :], padded[half + k :]
        left2, right2 = padded[half - k - 1 :], padded[half + k + 1 :]
        for j in range(samples):
            target[j] += near * (left[j] + right[j]) + far * (left2[j] + right2[j])
    if half % 2:
        weight = weights[half]
        left, right = padded, padded[2 * half :]
        for j in range(samples):
            target[j] += weight * (left[j] + right[j])


@kernel
def _row_of_9(padded: Floats32, weights: Floats32, target: Floats32) -> None:
    """Do the common length in one pass."""
    n = target.size
    w0, w1, w2, w3, w4 = weights[0], weights[1], weights[2], weights[3], weights[4]
    a, b, c, d, e = padded[:n], padded[1 : 1 + n], padded[2 : 2 + n], padded[3 : 3 + n], padded[4 : 4 + n]
    f, g, h, i = padded[5 : 5 + n], padded[6 : 6 + n], padded[7 : 7 + n], padded[8 : 8 + n]
    for j in range(n):
        target[j] = w0 * e[j] + w1 * (d[j] + f[j]) + w2 * (c[j] + g[j]) + w3 * (b[j] + h[j]) + w4 * (a[j] + i[j])


@kernel
def _mean_of_9(padded: Floats32, sums: Floats32, target: Floats32) -> None:
    """Add up sums of three: six loads a sample where weights of their own take nine."""
    n = target.size
    a, b, c, triple = padded[: n + 6], padded[1 : n + 7], padded[2 : n + 8], sums[: n + 6]
    for j in range(triple.size):
        triple[j] = a[j] + b[j] + c[j]
    d, e, f = triple[:n], triple[3 : n + 3], triple[6 : n + 6]
    for j in range(n):
        target[j] = np.float32(1.0 / 9.0) * (d[j] + e[j] + f[j])
