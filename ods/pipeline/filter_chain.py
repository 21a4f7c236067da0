"""The stages of a chain that make images of images, prepared for one geometry."""

from collections.abc import Sequence

from ods.base.arrays import Image
from ods.pipeline.image.double_buffer import DoubleBuffer
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.stage.configured import ConfiguredStage, blamed
from ods.pipeline.stage.step import PingContext


class FilterChain:
    """All stages but the one that detects. They may remember images."""

    def __init__(self, stages: Sequence[ConfiguredStage], fan: Fan, buffers: DoubleBuffer) -> None:
        """Prepare the stages. Raises StageError."""
        self.buffers = buffers
        self._steps = [(stage.label, stage.step(fan)) for stage in stages]

    def run(self, image: GainedImage, ping: PingContext) -> Image:
        """Return what the stages make of an image, (beams, samples); the next call reuses it. Raises StageError."""
        for label, step in self._steps:
            try:
                image = step(image, ping, self.buffers)
            except Exception as error:
                raise blamed(label, error) from error
        self.buffers.apply(image)
        return self.buffers.front
