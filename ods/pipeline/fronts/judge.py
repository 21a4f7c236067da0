"""Probability that the leading edges of echoes are an object's."""

import numpy as np

from ods.base.arrays import AnyArray, Floats
from ods.pipeline.fronts.network import learnt
from ods.pipeline.fronts.windows import Windows
from ods.pipeline.image.image_layout import ImageLayout
from ods.pipeline.image.samples.amplitude import SampleScale

LEAST_FRONT = 0.12
"""Of `Detection.front`, for weak detections. The tracker sees many images: one that is taken for the bottom now and
then costs less than a body that is never received."""
LEAST_TOLD = 1e-6
"""Least probability that is reported for a leading edge: 0 stands for an unknown one."""


class Fronts:
    """Judges the echoes of one image of a frame."""

    def __init__(self, layout: ImageLayout) -> None:
        self._windows = Windows(layout)
        self._network = learnt()

    def of(self, bearing_rad: Floats, near_m: Floats, samples: AnyArray, scale: SampleScale) -> Floats:
        """Return the `front` of echoes that set in at these places, (echoes,) each.

        samples: (beams, all samples), recorded.
        """
        scores = self._network.scores(self._windows.of(bearing_rad, near_m, samples, scale)).astype(np.float64)
        return np.maximum(1.0 / (1.0 + np.exp(-scores)), LEAST_TOLD)
