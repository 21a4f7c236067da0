"""Height of the background's crests, region by region: rough bottoms peak higher than speckle of the same noise.

The image is parted into tiles, whose highest cells are maxima of many: whatever the cells' own law, such maxima follow
an extreme-value law, of which two quantiles give location and scale (E. J. Gumbel, Statistics of Extremes, 1958). Held
against those of speckle that went through the same stages they show what a level on speckle corresponds to there.
"""

from collections.abc import Iterable
from itertools import islice

import numpy as np

from ods.base.arrays import Floats, Image
from ods.compiled import native
from ods.pipeline.detect.background.noise import background_and_noise
from ods.pipeline.stage.step import FIRST_IMAGES

_GRID = (16, 32)
"""Tiles across the beams and along the range, at most, and"""
_LEAST_TILE = (2, 16)
"""the least cells of one."""
_REGION = 4
"""Tiles along each side of a region."""


class LocalThreshold:
    """Measures images of one size; has their work space."""

    def __init__(self, shape: tuple[int, int]) -> None:
        beams, samples = (max(-(-n // most), least) for n, most, least in zip(shape, _GRID, _LEAST_TILE, strict=True))
        self._tile = beams, samples
        self.region = _REGION * beams, _REGION * samples
        """Its beams and samples; the last row and column may have fewer."""
        self._regions = -(-shape[0] // self.region[0]), -(-shape[1] // self.region[1])
        self.of_speckle = np.zeros(2)
        """The two quantiles of images without echoes, which `learn` fills."""

    def learn(self, images: Iterable[Image]) -> None:
        """Take in how high the crests of images without echoes reach, all from the same chain."""
        found = [np.empty((0, 2))]
        for image in islice(images, FIRST_IMAGES):
            background, noise = background_and_noise(image)
            if noise > 0.0:
                measured = crest_quantiles(image, self._tile, background, noise, self._regions).reshape(-1, 2)
                found.append(measured[measured[:, 0] > 0.0])
        all_found = np.concatenate(found)
        self.of_speckle[:] = all_found.mean(axis=0) if len(all_found) else 0.0

    def factors(self, image: Image, measured: tuple[float, float], level: float) -> Floats:
        """Return how many times as high as `level` the background of image (beams, samples) reaches: (rows, columns).

        measured: background and noise, in multiples of which `level` is over it. So many times `level` is reached in a
        region as seldom as `level` is by speckle; 1 where crests are no higher than those of speckle.
        """
        background, noise = measured
        middle, upper = self.of_speckle.tolist()
        if not upper > middle or noise <= 0.0:
            return np.ones((1, 1))
        factors = np.empty(self._regions)
        native.crest_factors(image, self._tile, _REGION, background, noise, level, middle, upper, factors)
        return factors


def crest_quantiles(
    image: Image, tile: tuple[int, int], background: float, noise: float, regions: tuple[int, int]
) -> Floats:
    """Return (rows, columns, 2): the two quantiles of each region and those around it; (0, 0) where tiles are few.

    Over the background, in multiples of the noise. Tiles whose cells are all 0 hold no data and do not count.
    """
    quantiles = np.empty((*regions, 2))
    native.crest_quantiles(image, tile, _REGION, background, noise, quantiles)
    return quantiles
