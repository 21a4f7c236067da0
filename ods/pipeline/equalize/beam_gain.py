"""Equalization by beam: beams of different gain are brought to the same level [SSIE, Image processing, stage 1]."""

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.equalize.by_range import sorted_middle
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.params import BeamGainParams
from ods.pipeline.stage.registry import image_stage
from ods.pipeline.stage.step import ImageStep

_PARTS = 25


@image_stage("equalize.beam_gain", BeamGainParams)
def beam_gain(params: BeamGainParams, fan: Fan) -> ImageStep:
    """Divide each beam by its level, relative to that of all: the median of the means of 25 parts of its range.

    So an object, or a wall along a beam, that fills less than half of the beam does not count, nor does more than
    `limit`. A beam of zeros stays so.
    """
    parts = np.empty(min(_PARTS, fan.samples), np.float32)
    work = np.empty(max(len(parts), len(fan.bearing_rad)), np.float32)
    level = np.empty(len(fan.bearing_rad), np.float32)

    def step(source: Image, out: Image) -> None:
        level_beams(source, np.float32(params.limit), parts, work, level, out)

    return step


@kernel
def level_beams(image: Image, limit: np.float32, parts: Floats32, work: Floats32, level: Floats32, out: Image) -> None:
    """Fill out with image (beams, samples), each beam over its level; parts, work, level (beams,) are work space."""
    beams, samples = image.shape
    for b in range(beams):
        for k in range(parts.size):
            part = image[b, k * samples // parts.size : (k + 1) * samples // parts.size]
            total = np.float32(0.0)
            for j in range(part.size):
                total += part[j]
            parts[k] = total / np.float32(part.size)
        level[b] = sorted_middle(parts, work)
    common = sorted_middle(level, work)
    for b in range(beams):
        gain = np.float32(1.0)
        if level[b] > np.float32(0.0) and common > np.float32(0.0):
            gain = min(max(common / level[b], np.float32(1.0) / limit), limit)
        source, target = image[b], out[b]
        for j in range(samples):
            target[j] = source[j] * gain
