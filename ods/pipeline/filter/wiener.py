"""Wiener filter along the beam, or along and across the beams [SSIE, Image processing, stage 2]."""

import numpy as np

from ods.base.arrays import AnyArray, Floats32, Image, Ints
from ods.base.kernel import kernel
from ods.pipeline.filter.linear import box_weights, symmetric_row, weigh_ring
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, SamplesStep, load_mirrored, load_row
from ods.pipeline.image.padding import mirrored
from ods.pipeline.stage.params import WienerParams
from ods.pipeline.stage.registry import image_stage


@image_stage("filter.wiener", WienerParams)
def wiener(params: WienerParams, fan: Fan) -> SamplesStep:
    """Lim's adaptive filter: mean + (sample - mean) * max(0, variance - noise) / variance, over the window.

    The noise is the mean of all local variances (J. S. Lim, Two-Dimensional Signal and Image Processing, 1990, ch. 9).
    """
    along, across = box_weights(params.window), box_weights(params.beams)
    rows = 2 * across.size - 1
    padded = np.empty((2, fan.samples + 2 * along.size), np.float32)
    rings = np.empty((2, rows, fan.samples), np.float32)
    variance = np.empty(fan.shape, np.float32)

    def run(samples: GainedImage, out: Image) -> None:
        wiener_filter(*samples.args, along, across, padded[0], padded[1], rings[0], rings[1], variance, out)

    return SamplesStep(run)


@kernel
def wiener_filter(
    cells: AnyArray,
    first: int,
    offset: np.float32,
    gain: Image,
    above: Ints,
    share: Floats32,
    along: Floats32,
    across: Floats32,
    padded: Floats32,
    sums: Floats32,
    means: Image,
    squares: Image,
    variance: Image,
    out: Image,
) -> None:
    """Fill out with samples (`GainedImage.args`) filtered by Lim's rule over the window of a symmetric filter.

    along, across: weights from the middle outwards, of sum 1 with their mirror image; the others are work space: padded
    and sums (samples + 2 half,), means and squares, rings of (2 reach + 1, samples), and variance (beams, samples).
    """
    beams, samples = out.shape
    half, reach = along.size - 1, across.size - 1
    noise = 0.0
    for b in range(-reach, beams + reach):
        row = b - reach
        slot = (b + reach) % means.shape[0]
        mean = means[slot] if reach else out[b]
        square = squares[slot] if reach else variance[b]
        load_mirrored(cells, first, offset, gain, above, share, mirrored(b, beams), half, samples, padded)
        symmetric_row(padded, along, sums, mean)
        for j in range(samples + 2 * half):
            padded[j] *= padded[j]
        symmetric_row(padded, along, sums, square)
        if reach and row >= 0:
            weigh_ring(means, across, b, out[row])
            weigh_ring(squares, across, b, variance[row])
        if row >= 0:
            noise += _to_variance(out[row], variance[row])
    floor = np.float32(noise / out.size)
    source = padded[:samples]
    for b in range(beams):  # read once more: cheaper than to keep a third image
        load_row(cells, first, offset, gain, above, share, b, source)
        _draw_to_mean(source, variance[b], floor, out[b])


@kernel
def _to_variance(mean: Floats32, square: Floats32) -> float:
    """Turn the mean square into the variance, in place; return the sum."""
    total = np.float32(0.0)
    for j in range(mean.size):
        spread = square[j] - mean[j] * mean[j]
        spread = spread if spread > np.float32(0.0) else np.float32(0.0)
        total += spread
        square[j] = spread
    return float(total)


@kernel
def _draw_to_mean(source: Floats32, variance: Floats32, floor: np.float32, mean: Floats32) -> None:
    """Turn the mean into the filtered row, in place."""
    for j in range(mean.size):
        whole = variance[j] if variance[j] > floor else floor
        share = (whole - floor) / (whole + np.float32(1e-30))
        mean[j] += share * (source[j] - mean[j])
