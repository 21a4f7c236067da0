"""Equalization by beam: beams of different gain are brought to the same level [SSIE, Image processing, stage 1]."""

import numpy as np

from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.stage.params import BeamGainParams
from ods.pipeline.stage.registry import gain_stage
from ods.pipeline.stage.step import GainStep

_EVERY = 16
"""Images of which one is measured."""


@gain_stage("equalize.beam_gain", BeamGainParams)
def beam_gain(params: BeamGainParams, fan: Fan) -> GainStep:
    """Divide each beam by its gain, which is what nearly all parts of its range agree on.

    Each part's mean is compared to the median of all beams there. A beam is loud if all but two of its 25 parts are
    louder than in the typical beam, by what the least of those is; likewise dark, but then the two nearest parts must
    be dark, too. So an object counts for nothing unless it fills a beam from near to far, nor does the shadow behind
    one. Gains go up to a factor of `limit`; an image without any is passed on as it is. The first image is measured,
    every sixteenth from there on, and the first one of another type of samples.
    """
    gain = np.empty(fan.shape[0], np.float32)
    count, differs = 0, False
    kind: np.dtype[np.generic] = np.dtype(np.void)

    def step(image: GainedImage) -> GainedImage:
        nonlocal count, differs, kind
        if count % _EVERY == 0 or image.cells.dtype != kind:
            kind = image.cells.dtype
            differs = native.measure_beam_gain(image, params.limit, gain)
        count += 1
        return image._replace(of_beam=image.of_beam * gain, plain=False) if differs else image

    return step
