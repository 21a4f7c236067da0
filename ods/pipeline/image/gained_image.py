"""Input of a stage: an image with a gain that is still to be applied, and the buffers that stages write to.

An image of 60 x 2000 float32 does not fit into a processor's fast cache beside another one, so writing it costs more
than most arithmetic on it. So equalizers only say what the gain is, at each range and slowly changing from beam to
beam, and the next stage applies it to each row as it reads that row; recorded counts become amplitude on the way.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats32, Image, Ints
from ods.compiled import native


class GainedImage(NamedTuple):
    """An image of (beams, samples) amplitudes: (cells[b, first + j] + offset) * gain at b, j.

    The gain of beam b is `of_beam[b]` times that of row `above[b]`, moved by `share[b]` towards the next row's.
    """

    cells: AnyArray
    """(beams, first + samples) uint8, uint16 or float32, C-contiguous."""
    first: int
    offset: np.float32
    gain: Image
    """(rows, samples)."""
    above: Ints
    """(beams,)."""
    share: Floats32
    """(beams,) 0 to 1; 0 for the last row."""
    of_beam: Floats32
    """(beams,)."""
    plain: bool = True
    """The gain is 1 everywhere."""


def of_gain_1(image: Image) -> GainedImage:
    """Return an image of (beams, samples) amplitudes as one of gain 1."""
    beams, samples = image.shape
    gain, of_beam = np.ones((1, samples), np.float32), np.ones(beams, np.float32)
    return GainedImage(image, 0, np.float32(0.0), gain, np.zeros(beams, np.int64), np.zeros(beams, np.float32), of_beam)


def applied(image: GainedImage) -> Image:
    """Return a new image (beams, samples) of the amplitudes."""
    out = np.empty((image.above.size, image.gain.shape[1]), np.float32)
    native.write_image(image, out)
    return out


class DoubleBuffer:
    """Two images of one shape that take turns: the front one is the newest, and is read; the back one is written."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.front, self.back = np.empty(shape, np.float32), np.empty(shape, np.float32)
        self._front, self._back = of_gain_1(self.front), of_gain_1(self.back)

    def flip(self) -> GainedImage:
        """Make the image that was written the front one, and return it."""
        self.front, self.back = self.back, self.front
        self._front, self._back = self._back, self._front
        return self._front

    def apply(self, image: GainedImage) -> GainedImage:
        """Return the image with its gain applied, which then is the front one."""
        if image.plain and image.cells.dtype.kind == "f":
            return image
        native.write_image(image, self.back)
        return self.flip()
