"""How high the background's crests reach, region by region: rough bottoms peak higher than speckle of the same noise.

The image is parted into tiles, whose highest cells are maxima of many: whatever the cells' own law, such maxima follow
an extreme-value law, of which two quantiles tell place and scale (E. J. Gumbel, Statistics of Extremes, 1958). Held
against those of speckle that went through the same stages they tell what a level on speckle corresponds to there.
"""

from collections.abc import Iterable
from itertools import islice

import numpy as np

from ods.base.arrays import Floats, Image, Ints32, Mask
from ods.compiled import native
from ods.pipeline.detect.noise import NoiseMeter
from ods.pipeline.image.regions import Regions, Runs

_GRID = (16, 32)
"""Tiles across the beams and along the range, at most, and"""
_LEAST_TILE = (2, 16)
"""the least cells of one."""
_REGION = 4
"""Tiles along each side of a region; it is judged with the eight around it."""
_BINS = 320
"""Of the histograms of maxima."""
_BY_CHANCE = 1.12
"""Regions of speckle itself differ by so much: 19 of 20 by less."""
_LEARNT_IMAGES = 8


class CrestMeter:
    """Measures images of one size; has their work space."""

    def __init__(self, shape: tuple[int, int]) -> None:
        beams, samples = (max(-(-n // most), least) for n, most, least in zip(shape, _GRID, _LEAST_TILE, strict=True))
        self._tile = beams, samples
        tiles = -(-shape[0] // beams), -(-shape[1] // samples)
        regions = -(-tiles[0] // _REGION), -(-tiles[1] // _REGION)
        self._histograms = np.empty((*regions, _BINS), np.int32)
        self._scaled = np.empty(shape, np.float32)
        self.of_speckle = np.zeros(2)
        """The two quantiles of images without echoes, which `learn` fills."""

    def learn(self, images: Iterable[Image]) -> None:
        """Take in how high the crests of images without echoes reach, all from the same chain."""
        meter, found = NoiseMeter(), [np.empty((0, 2))]
        for image in islice(images, _LEARNT_IMAGES):
            background, noise = meter.background_and_noise(image)
            if noise > 0.0:
                measured = self._measure(image, background, noise).reshape(-1, 2)
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
        share = (level - middle) / (upper - middle)  # of the way from the one to the other quantile
        factors: Floats = self._measure(image, background, noise) @ ((1.0 - share) / level, share / level)
        factors[factors < _BY_CHANCE] = 1.0
        return factors

    def levelled(self, image: Image, background: float, factors: Floats) -> Image:
        """Return image (beams, samples) with what lies over the background divided by its region's factor.

        The same array is returned where all are 1.
        """
        if (factors == 1.0).all():
            return image
        shrink(image, background, (1.0 / factors).astype(np.float32), self._region, self._scaled)
        return self._scaled

    def reaching(self, image: Image, regions: Regions, levels: Image) -> Mask:
        """Tell (total,) which regions of image (beams, samples) reach the level of a region of `levels` somewhere.

        levels: (rows, columns), or (1, 1) for the whole image.
        """
        region = self._region if levels.size > 1 else image.shape
        return reaching(image, regions.runs, regions.total, levels, region)

    @property
    def _region(self) -> tuple[int, int]:
        return _REGION * self._tile[0], _REGION * self._tile[1]

    def _measure(self, image: Image, background: float, noise: float) -> Floats:
        """Return the two quantiles in each region, (rows, columns, 2), over the background, multiples of the noise."""
        count_maxima(image, self._tile, background, noise, self._histograms)
        return quantiles_around(self._histograms)


def count_maxima(image: Image, tile: tuple[int, int], background: float, noise: float, histograms: Ints32) -> None:
    """Fill histograms (rows, columns, bins) with the tiles' maxima of each region, as `CrestMeter._measure` says.

    Tiles whose cells are all 0 hold no data and do not count.
    """
    native.count_maxima(image, tile, _REGION, background, noise, histograms)


def quantiles_around(histograms: Ints32) -> Floats:
    """Return (rows, columns, 2): the two quantiles of each region and those around it; (0, 0) where tiles are few."""
    quantiles = np.empty((*histograms.shape[:2], 2))
    native.quantiles_around(histograms, quantiles)
    return quantiles


def shrink(image: Image, background: float, factors: Image, region: tuple[int, int], out: Image) -> None:
    """Fill out with background + (image - background) * the factor (rows, columns) of the region."""
    native.shrink(image, background, factors, region, out)


def reaching(image: Image, runs: Runs, total: int, levels: Image, region: tuple[int, int]) -> Mask:
    """Tell (total,) which regions of runs have a cell above the level (rows, columns) of its region of the image."""
    found = np.empty(total, np.bool_)
    native.reaching(image, runs, levels, region, found)
    return found
