"""Recursive filter in range, run both ways: no delay, and a cost that does not depend on its length."""

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, load_row
from ods.pipeline.stage.params import IirParams
from ods.pipeline.stage.registry import gained_image_stage
from ods.pipeline.stage.step import GainedImageStep


@gained_image_stage("filter.iir", IirParams)
def iir(params: IirParams, fan: Fan) -> GainedImageStep:
    """First-order low-pass, forwards and backwards: weights fall as exp(-distance / length)."""
    pole = np.float32(np.exp(-1.0 / params.length))
    sums = np.empty((2, fan.samples), np.float32)

    def step(image: GainedImage, out: Image) -> None:
        two_way(image, pole, sums[0], sums[1], out)

    return step


@kernel
def two_way(image: GainedImage, pole: np.float32, left: Floats32, right: Floats32, out: Image) -> None:
    """Fill out with the image's samples weighted by pole^distance on both sides, of unit sum.

    At an end the missing side is left out.
    """
    samples = out.shape[1]
    for b in range(out.shape[0]):
        row = out[b]
        load_row(image, b, row)
        total, back = np.float32(0.0), np.float32(0.0)
        for j in range(samples):  # both ways at once: two chains of dependent sums hide each other's latency
            total = row[j] + pole * total
            back = row[samples - 1 - j] + pole * back
            left[j], right[samples - 1 - j] = total, back
        for j in range(samples):
            row[j] = left[j] + right[j] - row[j]
    weight = np.float32(1.0)
    whole = (np.float32(1.0) + pole) / (np.float32(1.0) - pole)
    tail = pole / (np.float32(1.0) - pole)
    for j in range(samples):
        left[j] = tail * weight
        weight *= pole
    for j in range(samples):
        right[j] = np.float32(1.0) / (whole - left[j] - left[samples - 1 - j])
    for b in range(out.shape[0]):
        row = out[b]
        for j in range(samples):
            row[j] *= right[j]
