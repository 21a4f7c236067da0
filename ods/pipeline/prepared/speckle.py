"""Images without echoes, from which detectors learn what the stages before them make of noise of many kinds."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Image
from ods.pipeline.prepared.filter_chain import FilterChain
from ods.pipeline.stage.step import FIRST_IMAGES, PingContext

LEARNT_CELLS = 13_000_000
"""Cells of speckle from which a detector learns, if it has to, all kinds together,"""
_LEARNT_IMAGES = 2
"""and the least number of images of each kind."""
_TEXTURES = 65_536
"""Values of the texture that are drawn once for each kind: a gamma variate takes as long as ten cells of speckle."""

KeepAlive = Callable[[], object]
"""Called during long work, so that the process does not count as hung."""


class Speckle(NamedTuple):
    """A kind of speckle: the mean of several looks, on a gamma distributed texture, which makes it K-distributed."""

    looks: int = 1
    texture: float = 0.0
    """Shape of the texture's distribution; 0: there is none."""
    patch: tuple[int, int] | None = None
    """Beams and samples that share one value of the texture; None: none do."""
    correlated: int = 1
    """Samples whose fields are added up to one; more than one for a single look without texture only."""
    louder: float = 1.0
    """How many times as loud the last range is as the first."""


_PATCH = 3, 24
"""Beams and samples of a patch."""
KINDS = (
    Speckle(), Speckle(looks=2), Speckle(looks=4), Speckle(looks=8), Speckle(correlated=3), Speckle(louder=4.0),
    Speckle(texture=0.5), Speckle(texture=1.0), Speckle(texture=2.0), Speckle(texture=5.0),
    Speckle(texture=0.5, patch=_PATCH), Speckle(texture=1.0, patch=_PATCH), Speckle(texture=5.0, patch=_PATCH),
)  # fmt: skip


def filtered_speckle(
    filters: FilterChain, stride: int, cells: int, alive: KeepAlive | None = None
) -> Iterator[Iterator[Image]]:
    """Yield for each kind of speckle what filters make of images of it, no two alike; each is soon reused.

    stride: samples whose amplitudes are averaged to a cell's; cells: about this number in all;
    alive: is called before each image.
    """
    rng = np.random.Generator(np.random.SFC64(0))
    images = _LEARNT_IMAGES + cells // (len(KINDS) * filters.buffers.back.size)
    begin = 0
    for kind in KINDS:
        stop = begin + (images if begin else max(images, FIRST_IMAGES))
        yield _filtered(filters, stride, speckle_generator(kind, rng), range(begin, stop), alive)
        begin = stop


def _filtered(
    filters: FilterChain, stride: int, draw: Callable[[Image], None], numbers: range, alive: KeepAlive | None
) -> Iterator[Image]:
    buffers = filters.buffers
    beams, columns = buffers.back.shape
    samples = np.empty((beams, columns * stride), np.float32)
    for number in numbers:
        if alive:
            alive()
        draw(samples)
        np.sqrt(samples, out=samples)
        buffers.back[:] = samples[:, ::stride]
        for k in range(1, stride):
            buffers.back[:] += samples[:, k::stride]
        buffers.back[:] /= np.float32(stride)
        yield filters.run(buffers.flip(), PingContext(number, None))


def speckle_generator(kind: Speckle, rng: np.random.Generator) -> Callable[[Image], None]:
    """Return what fills an image (beams, samples) with intensities of mean 1, others at each call."""
    if kind.correlated > 1:
        return lambda out: _draw_correlated(kind.correlated, rng, out)
    textures = rng.standard_gamma(kind.texture, _TEXTURES, np.float32) / np.float32(kind.texture or 1.0)

    def draw(out: Image) -> None:
        if kind.looks == 1:
            rng.standard_exponential(out=out, dtype=np.float32)
        else:
            rng.standard_gamma(kind.looks, out=out, dtype=np.float32)
            out /= np.float32(kind.looks)
        if kind.texture:
            high, long = kind.patch or (1, 1)
            patches = (-(-out.shape[0] // high), -(-out.shape[1] // long))
            texture = textures[rng.integers(_TEXTURES, size=patches, dtype=np.uint16)]
            if kind.patch:
                texture = texture.repeat(high, axis=0)[: len(out)].repeat(long, axis=1)[:, : out.shape[1]]
            out *= texture
        if kind.louder != 1.0:
            gain = np.geomspace(1.0, kind.louder**2, out.shape[1], dtype=np.float32)
            out *= gain / gain.mean()

    return draw


def _draw_correlated(over: int, rng: np.random.Generator, out: Image) -> None:
    samples = out.shape[1]
    out[:] = np.float32(0.0)
    for _ in range(2):  # in phase and in quadrature
        field = rng.standard_normal((len(out), samples + over - 1), np.float32)
        total = field[:, :samples].copy()
        for k in range(1, over):
            total += field[:, k : k + samples]
        out += np.square(total, out=total)
    out /= np.float32(2 * over)
