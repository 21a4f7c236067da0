"""The stages of a chain that make images of images, prepared for one geometry."""

from collections.abc import Sequence

import numpy as np

from ods.base.arrays import Image
from ods.pipeline.image.double_buffer import DoubleBuffer
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, applied
from ods.pipeline.stage.configured import ConfiguredStage, blamed
from ods.pipeline.stage.params import NotANumberError
from ods.pipeline.stage.step import PingContext
from ods.pipeline.stage.watch import RECORDED, StageImage, Watch


class FilterChain:
    """All stages but the one that detects. They may remember images."""

    def __init__(
        self, stages: Sequence[ConfiguredStage], fan: Fan, buffers: DoubleBuffer, watch: Watch | None = None
    ) -> None:
        """Prepare the stages. watch: is shown what each makes. Raises StageError."""
        self.buffers = buffers
        self._fan = fan
        self._watch = watch
        self._steps = [(stage, stage.step(fan)) for stage in stages]

    def run(self, image: GainedImage, ping: PingContext, *, check: bool = False) -> Image:
        """Return what the stages make of an image, (beams, samples); the next call reuses it.

        Raises StageError; with `check` also for the first stage whose image is not finite.
        """
        self._show(RECORDED, image)
        for stage, step in self._steps:
            try:
                image = step(image, ping, self.buffers)
                if check and not np.isfinite(applied(image)).all():
                    raise NotANumberError
            except Exception as error:
                raise blamed(stage.label, error) from error
            self._show(stage.name, image)
        self.buffers.apply(image)
        return self.buffers.front

    def _show(self, label: str, image: GainedImage) -> None:
        if self._watch:
            self._watch(StageImage(label, applied(image), self._fan))
