"""Buffers for the images of a chain's stages: two that take turns."""

import numpy as np

from ods.base.arrays import Image
from ods.pipeline.image.gained_image import GainedImage, of_gain_1, write_image


class DoubleBuffer:
    """Two images of one shape: the front one is the newest, and is read; the back one is free, and is written."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self._images = (np.empty(shape, np.float32), np.empty(shape, np.float32))
        self._of_gain_1 = tuple(of_gain_1(image) for image in self._images)
        self._front = 0

    @property
    def front(self) -> Image:
        """Return the newest image, (beams, samples)."""
        return self._images[self._front]

    @property
    def back(self) -> Image:
        """Return the image that the next stage is to write, (beams, samples)."""
        return self._images[1 - self._front]

    def restart(self) -> None:
        """Begin with a new ping, in the buffer that the last one began in: it may still be in the cache."""
        self._front = 0

    def flip(self) -> GainedImage:
        """Make the image that was written the front one, and return it."""
        self._front = 1 - self._front
        return self._of_gain_1[self._front]

    def apply(self, image: GainedImage) -> GainedImage:
        """Return the image with its gain applied, which then is the front one."""
        if image.is_applied:
            return image
        write_image(image, self.back)
        return self.flip()
