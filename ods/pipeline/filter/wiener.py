"""Wiener filter along the beam, or along and across the beams [SSIE, Image processing, stage 2]."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.filter.linear import SeparableFilter, box_weights, separable_filter, symmetric_row, weigh_ring
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, load_mirrored, load_row
from ods.pipeline.image.padding import mirrored
from ods.pipeline.stage.params import WienerParams
from ods.pipeline.stage.registry import gained_image_stage
from ods.pipeline.stage.step import GainedImageStep


@gained_image_stage("filter.wiener", WienerParams)
def wiener(params: WienerParams, fan: Fan) -> GainedImageStep:
    """Lim's adaptive filter: mean + (sample - mean) * max(0, variance - noise) / variance, over the window.

    The noise is the mean of all local variances (J. S. Lim, Two-Dimensional Signal and Image Processing, 1990, ch. 9).
    """
    weights = separable_filter(box_weights(params.window), box_weights(params.beams), fan.samples)
    work = WienerWork(weights.ring, np.empty_like(weights.ring), np.empty(fan.shape, np.float32))

    def step(image: GainedImage, out: Image) -> None:
        wiener_filter(image, weights, work, out)

    return step


class WienerWork(NamedTuple):
    """Work space of the Wiener filter."""

    means: Image
    """(2 reach + 1, samples), the means in range of the rows around the present one,"""
    squares: Image
    """and those of their squares."""
    variance: Image
    """(beams, samples)."""


@kernel
def wiener_filter(image: GainedImage, weights: SeparableFilter, work: WienerWork, out: Image) -> None:
    """Fill out (beams, samples) with image filtered by Lim's rule; weights: of the window."""
    along, across, padded, sums = weights.along, weights.across, weights.padded, weights.sums
    beams, samples = out.shape
    half, reach = along.size - 1, across.size - 1
    noise = 0.0
    for b in range(-reach, beams + reach):
        row = b - reach
        slot = (b + reach) % work.means.shape[0]
        mean = work.means[slot] if reach else out[b]
        square = work.squares[slot] if reach else work.variance[b]
        load_mirrored(image, mirrored(b, beams), half, padded)
        symmetric_row(padded, along, sums, mean)
        for j in range(samples + 2 * half):
            padded[j] *= padded[j]
        symmetric_row(padded, along, sums, square)
        if reach and row >= 0:
            weigh_ring(work.means, across, b, out[row])
            weigh_ring(work.squares, across, b, work.variance[row])
        if row >= 0:
            noise += _to_variance(out[row], work.variance[row])
    floor = np.float32(noise / out.size)
    source = padded[:samples]
    for b in range(beams):  # read once more: cheaper than to keep a third image
        load_row(image, b, source)
        _draw_to_mean(source, work.variance[b], floor, out[b])


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
