"""What a stage reads: samples with a gain that is still to be applied.

An image of 60 x 2000 float32 does not fit into a processor's fast cache beside another one, so writing it costs more
than most arithmetic on it. So equalizers only say what the gain is, at each range and slowly changing from beam to
beam, and the next stage applies it to each row as it reads that row; recorded counts become amplitude on the way.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats32, Image, Ints
from ods.base.kernel import kernel
from ods.pipeline.image.padding import mirror_ends


class GainedImage(NamedTuple):
    """An image of (beams, samples) amplitudes: (cells[b, first + j] + offset) * gain at b, j.

    The gain of beam b is that of row `above[b]`, moved by `share[b]` towards the next row's.
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
    plain: bool = True
    """The gain is 1 everywhere."""

    @property
    def args(self) -> tuple[AnyArray, int, np.float32, Image, Ints, Floats32]:
        """What kernels take: all but `plain`."""
        return self[:6]

    def with_column_gain(self, gain: Image) -> "GainedImage":
        """Return the samples with gain, (1, samples); that of before is part of it."""
        return self._replace(gain=gain, plain=False)


def samples_of(image: Image) -> GainedImage:
    """Return an image of (beams, samples) as samples of gain 1."""
    beams, samples = image.shape
    gain = np.ones((1, samples), np.float32)
    return GainedImage(image, 0, np.float32(0.0), gain, np.zeros(beams, np.int64), np.zeros(beams, np.float32))


class SamplesStep:
    """A stage that applies the gain itself, while it reads."""

    def __init__(self, run: Callable[[GainedImage, Image], None]) -> None:
        self.run = run

    def __call__(self, source: Image, out: Image) -> None:
        """Fill out from source, both (beams, samples)."""
        self.run(samples_of(source), out)


class GainStep:
    """A stage that does nothing but change the gain."""

    def __init__(self, regain: Callable[[GainedImage], GainedImage]) -> None:
        self.regain = regain

    def __call__(self, source: Image, out: Image) -> None:
        """Fill out from source, both (beams, samples)."""
        write_image(*self.regain(samples_of(source)).args, out)


@kernel
def write_image(
    cells: AnyArray, first: int, offset: np.float32, gain: Image, above: Ints, share: Floats32, out: Image
) -> None:
    """Fill out (beams, samples) with the amplitudes that `GainedImage.args` stand for."""
    for b in range(out.shape[0]):
        load_row(cells, first, offset, gain, above, share, b, out[b])


@kernel
def load_row(
    cells: AnyArray, first: int, offset: np.float32, gain: Image, above: Ints, share: Floats32, beam: int, out: Floats32
) -> None:
    """Fill out (samples,) with one beam's amplitudes."""
    source = cells[beam, first:]
    near, weight = gain[above[beam]], share[beam]
    if weight == np.float32(0.0):
        for j in range(out.size):
            out[j] = (np.float32(source[j]) + offset) * near[j]
    else:
        far = gain[above[beam] + 1]
        for j in range(out.size):
            out[j] = (np.float32(source[j]) + offset) * (near[j] + weight * (far[j] - near[j]))


@kernel
def load_mirrored(
    cells: AnyArray,
    first: int,
    offset: np.float32,
    gain: Image,
    above: Ints,
    share: Floats32,
    beam: int,
    half: int,
    samples: int,
    padded: Floats32,
) -> None:
    """Fill padded (at least samples + 2 half,) with one beam's amplitudes and `half` mirrored ones at both ends."""
    load_row(cells, first, offset, gain, above, share, beam, padded[half : half + samples])
    mirror_ends(padded, half, samples)
