"""The stages of a chain that make images of images, prepared for one geometry."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ods.base.arrays import Image
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import DoubleBuffer, GainedImage, applied
from ods.pipeline.stage.configured import ConfiguredStage, error_of
from ods.pipeline.stage.params import NotANumberError
from ods.pipeline.stage.step import PingContext, StageKind
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
        self._steps = [(entry.label, entry.name, entry.stage.kind, entry.prepared(fan)) for entry in stages]

    def run(self, image: GainedImage, ping: PingContext, *, check: bool = False) -> Image:
        """Return what the stages make of an image, (beams, samples); the next call reuses it.

        Raises StageError; with `check` also for the first stage whose image is not finite.
        """
        if self._watch:
            self._watch(StageImage(RECORDED, applied(image), self._fan))
        for label, name, kind, step in self._steps:
            try:
                image = result_of(kind, step, image, ping, self.buffers)
                if check and not np.isfinite(applied(image)).all():
                    raise NotANumberError
            except Exception as error:
                raise error_of(label, error) from error
            if self._watch:
                self._watch(StageImage(name, applied(image), self._fan))
        self.buffers.apply(image)
        return self.buffers.front


def result_of(kind: StageKind, step: Any, image: GainedImage, ping: PingContext, buffers: DoubleBuffer) -> GainedImage:
    """Return what a step of this kind makes of an image, which lies in the front buffer or is a recorded one.

    What a step writes, it writes to the back buffer, which then is the front one.
    """
    if kind == "gain":
        varies_with_beam = image.gain.shape[0] > 1
        changed: GainedImage = step(buffers.apply(image) if varies_with_beam else image)
        return changed
    if kind == "gained image":
        step(image, buffers.back)
        return buffers.flip()
    buffers.apply(image)
    if kind == "image":
        step(buffers.front, buffers.back)
    else:
        step(buffers.front, buffers.back, ping)
    return buffers.flip()
