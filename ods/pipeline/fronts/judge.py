"""How likely echoes set in as a body does."""

from collections.abc import Sequence

import msgspec
import numpy as np

from ods.base.arrays import AnyArray
from ods.messages import Detection
from ods.pipeline.fronts.network import learnt
from ods.pipeline.fronts.windows import Windows
from ods.pipeline.image.amplitude import SampleScale
from ods.pipeline.image_layout import ImageLayout

LEAST_FRONT = 0.12
"""Of `Detection.front`, for faint echoes. The tracker looks at many images: one that is taken for the bottom now and
then costs less than a body that is never heard."""
LEAST_TOLD = 1e-6
"""No front is told to be less likely a body's: 0 is that it is not told."""


class Fronts:
    """Judges the echoes of one image of a frame."""

    def __init__(self, layout: ImageLayout) -> None:
        self._windows = Windows(layout)
        self._network = learnt()

    def judged(self, echoes: Sequence[Detection], samples: AnyArray, scale: SampleScale) -> list[Detection]:
        """Return the echoes with their `front`; samples: (beams, all samples), recorded."""
        if not echoes:
            return []
        scores = self._network.scores(self._windows.of(echoes, samples, scale))
        fronts = np.maximum(np.exp(-np.logaddexp(0.0, -scores)), LEAST_TOLD).tolist()
        return [msgspec.structs.replace(echo, front=front) for echo, front in zip(echoes, fronts, strict=True)]
