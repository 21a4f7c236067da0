"""Which faint echoes set in as a body does."""

from collections.abc import Sequence
from itertools import compress

from ods.base.arrays import AnyArray
from ods.messages import Detection
from ods.pipeline.fronts.network import learnt
from ods.pipeline.fronts.windows import Windows
from ods.pipeline.image.amplitude import SampleScale
from ods.pipeline.image_layout import ImageLayout

LEAST_SCORE = -1.0
"""Of a body's front, see `Network.scores`. The tracker looks at many images: one that is taken for the bottom now and
then costs less than a body that is never heard."""


class Fronts:
    """Judges the echoes of one image of a frame."""

    def __init__(self, layout: ImageLayout) -> None:
        self._windows = Windows(layout)
        self._network = learnt()

    def of_bodies(self, echoes: Sequence[Detection], samples: AnyArray, scale: SampleScale) -> list[Detection]:
        """Return those that may be a body's; samples: (beams, all samples), recorded."""
        if not echoes:
            return []
        scores = self._network.scores(self._windows.of(echoes, samples, scale))
        return list(compress(echoes, scores > LEAST_SCORE))
