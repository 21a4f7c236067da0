"""Linear and Wiener filters along the beam [SSIE, Image processing, stage 2]; mirrored at the range ends."""

import numpy as np
from numpy.typing import NDArray

from ods.pipeline.fan import Fan, Image
from ods.pipeline.kernel import kernel
from ods.pipeline.mirror import Row, mirror_row
from ods.pipeline.params import BoxParams, FirParams, WienerParams
from ods.pipeline.registry import ImageStep, image_stage


@image_stage("filter.fir", FirParams)
def fir(params: FirParams, fan: Fan) -> ImageStep:
    """Low-pass filter of odd length and linear phase: echoes keep their range."""
    weights = lowpass_weights(params.taps, params.cutoff)
    padded = np.empty(fan.samples + 2 * weights.size, np.float32)

    def step(source: Image, out: Image) -> None:
        symmetric_filter(source, weights, padded, out)

    return step


@image_stage("filter.box", BoxParams)
def box(params: BoxParams, fan: Fan) -> ImageStep:
    """Moving average: of all filters of its length the one that takes out most of the speckle."""
    weights = box_weights(params.window)
    padded = np.empty(fan.samples + 2 * weights.size, np.float32)

    def step(source: Image, out: Image) -> None:
        symmetric_filter(source, weights, padded, out)

    return step


@image_stage("filter.wiener", WienerParams)
def wiener(params: WienerParams, fan: Fan) -> ImageStep:
    """Lim's adaptive filter: mean + (sample - mean) * max(0, variance - noise) / variance, over the window.

    The noise is the mean of all local variances (J. S. Lim, Two-Dimensional Signal and Image Processing, 1990, ch. 9).
    """
    weights = box_weights(params.window)
    padded = np.empty(fan.samples + 2 * weights.size, np.float32)
    squares = np.empty(fan.samples, np.float32)
    variance = np.empty(fan.shape, np.float32)

    def step(source: Image, out: Image) -> None:
        wiener_filter(source, weights, padded, squares, variance, out)

    return step


def box_weights(window: int) -> NDArray[np.float32]:
    """Return the weights of a moving average, (window // 2 + 1,), in the form of `lowpass_weights`; window odd."""
    return np.full(window // 2 + 1, 1.0 / window, np.float32)


def lowpass_weights(taps: int, cutoff: float) -> NDArray[np.float32]:
    """Return the middle weight and those to its right, (taps // 2 + 1,), of a Hamming-windowed sinc of unit gain.

    taps: odd; cutoff: fraction of the Nyquist frequency. The other half mirrors this one.
    """
    offset = np.arange(taps // 2 + 1)
    window = 0.54 + 0.46 * np.cos(2.0 * np.pi * offset / max(1, taps - 1))
    half = np.sinc(cutoff * offset) * window
    return np.asarray(half / (2.0 * half.sum() - half[0]), np.float32)


@kernel
def symmetric_filter(image: Image, weights: Row, padded: Row, out: Image) -> None:
    """Fill out with image (beams, samples) convolved along the rows with a symmetric filter.

    weights: (half + 1,) from the middle outwards; padded: work space of samples + 2 half.
    """
    half = weights.size - 1
    for b in range(image.shape[0]):
        mirror_row(image[b], half, padded)
        symmetric_row(padded, weights, out[b])


@kernel
def symmetric_row(padded: Row, weights: Row, target: Row) -> None:
    """Convolve one mirrored row: padded (samples + 2 half,), weights (half + 1,), target (samples,)."""
    samples = target.size
    half = weights.size - 1
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
def wiener_filter(image: Image, weights: Row, padded: Row, squares: Row, variance: Image, out: Image) -> None:
    """Fill out with image (beams, samples) filtered by Lim's rule over the window of a symmetric filter.

    weights: (half + 1,), of sum 1 with their mirror image; padded (samples + 2 half), squares (samples) and variance
    (beams, samples) are work space.
    """
    samples = image.shape[1]
    half = weights.size - 1
    noise = 0.0
    for b in range(image.shape[0]):
        mean, spread = out[b], variance[b]
        mirror_row(image[b], half, padded)
        symmetric_row(padded, weights, mean)
        for j in range(samples + 2 * half):
            padded[j] *= padded[j]
        symmetric_row(padded, weights, squares)
        total = np.float32(0.0)
        for j in range(samples):
            spread[j] = max(squares[j] - mean[j] * mean[j], np.float32(0.0))
            total += spread[j]
        noise += float(total)
    floor = np.float32(noise / image.size)
    for b in range(image.shape[0]):
        source, target, spread = image[b], out[b], variance[b]
        for j in range(samples):
            share = (spread[j] - floor) / spread[j] if spread[j] > floor else np.float32(0.0)
            target[j] += share * (source[j] - target[j])
