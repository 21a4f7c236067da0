"""Input of a stage: an image with a gain that is still to be applied.

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

    @property
    def is_applied(self) -> bool:
        """The cells are the amplitudes; there is nothing to apply."""
        return self.plain and self.cells.dtype.kind == "f"

    def with_cells(self, cells: AnyArray, first: int, offset: np.float32) -> "GainedImage":
        """Return the gain with other cells."""
        return GainedImage(cells, first, offset, self.gain, self.above, self.share, self.of_beam, self.plain)

    def with_column_gain(self, gain: Image) -> "GainedImage":
        """Return the image with gain, (1, samples); that of before is part of it."""
        return GainedImage(self.cells, self.first, self.offset, gain, self.above, self.share, self.of_beam, False)

    def with_beam_gain(self, of_beam: Floats32) -> "GainedImage":
        """Return the image with each beam multiplied by of_beam, (beams,), besides."""
        factor = self.of_beam * of_beam
        return GainedImage(self.cells, self.first, self.offset, self.gain, self.above, self.share, factor, False)

    def with_gain(self, gain: Image, above: Ints, share: Floats32) -> "GainedImage":
        """Return the image with gain, (rows, samples); that of before is part of it."""
        return GainedImage(self.cells, self.first, self.offset, gain, above, share, self.of_beam, False)


def of_gain_1(image: Image) -> GainedImage:
    """Return an image of (beams, samples) amplitudes as one of gain 1."""
    beams, samples = image.shape
    gain, of_beam = np.ones((1, samples), np.float32), np.ones(beams, np.float32)
    return GainedImage(image, 0, np.float32(0.0), gain, np.zeros(beams, np.int64), np.zeros(beams, np.float32), of_beam)


def applied(image: GainedImage) -> Image:
    """Return a new image (beams, samples) of the amplitudes."""
    out = np.empty((image.above.size, image.gain.shape[1]), np.float32)
    write_image(image, out)
    return out


def write_image(image: GainedImage, out: Image) -> None:
    """Fill out (beams, samples) with the amplitudes."""
    native.write_image(image, out)
