"""How high the background's crests reach, region by region: rough bottoms peak higher than speckle of the same noise.

The image is parted into tiles, whose highest cells are maxima of many: whatever the cells' own law, such maxima follow
an extreme-value law, of which two quantiles tell place and scale (E. J. Gumbel, Statistics of Extremes, 1958). Held
against those of speckle that went through the same stages they tell what a level on speckle corresponds to there.
"""

from collections.abc import Iterable
from itertools import islice

import numpy as np

from ods.base.arrays import Floats, Floats32, Image, Ints32, Mask
from ods.compiled.kernel import kernel
from ods.pipeline.detect.noise import NoiseMeter
from ods.pipeline.image.regions import Regions, Runs

_GRID = (16, 32)
"""Tiles across the beams and along the range, at most, and"""
_LEAST_TILE = (2, 16)
"""the least cells of one."""
_REGION = 4
"""Tiles along each side of a region; it is judged with the eight around it."""
_LEAST_TILES = 32
"""Fewer, in a region and those around it, tell nothing."""
_BINS, _BIN = 320, 0.1
"""Of the histograms of maxima, in multiples of the noise."""
_MIDDLE, _UPPER = 0.5, 0.9
"""The two quantiles. An object fills few tiles and cannot move them far."""
_TOO_HIGH = 2.5
"""Maxima more than so many times as far over the background as the middle one are objects: a wall fills a tenth."""
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
        middle, upper = self.of_speckle
        if not upper > middle or noise <= 0.0:
            return np.ones((1, 1))
        crests = self._measure(image, background, noise)
        reached = crests[..., 0] + (crests[..., 1] - crests[..., 0]) * (level - middle) / (upper - middle)
        factors = reached / level
        factors[factors < _BY_CHANCE] = 1.0
        return factors

    def levelled(self, image: Image, background: float, factors: Floats) -> Image:
        """Return image (beams, samples) with what lies over the background divided by its region's factor.

        The same array is returned where all are 1.
        """
        if (factors == 1.0).all():
            return image
        shrink(image, np.float32(background), (1.0 / factors).astype(np.float32), self._region, self._scaled)
        return self._scaled

    def faint(self, image: Image, regions: Regions, levels: Image) -> Mask | None:
        """Tell (total,) which regions of image (beams, samples) nowhere reach the level of its region of `levels`.

        levels: (rows, columns), or (1, 1) for the whole image. None: there are none.
        """
        if not regions.total:
            return None
        region = self._region if levels.size > 1 else image.shape
        return ~reaching(image, regions.runs, regions.total, levels, region)

    @property
    def _region(self) -> tuple[int, int]:
        return _REGION * self._tile[0], _REGION * self._tile[1]

    def _measure(self, image: Image, background: float, noise: float) -> Floats:
        """Return the two quantiles in each region, (rows, columns, 2), over the background, multiples of the noise."""
        count_maxima(image, self._tile, background, noise, self._histograms)
        return quantiles_around(self._histograms)


@kernel
def count_maxima(image: Image, tile: tuple[int, int], background: float, noise: float, histograms: Ints32) -> None:
    """Fill histograms (rows, columns, bins) with the tiles' maxima of each region, as `CrestMeter._measure` says.

    Tiles whose cells are all 0 hold no data and do not count.
    """
    beams, samples = image.shape
    highest = np.empty(samples, np.float32)
    histograms[:] = 0
    most = histograms.shape[2] - 1
    for first in range(0, beams, tile[0]):
        row = histograms[first // (tile[0] * _REGION)]
        highest[:] = np.float32(0.0)
        for beam in range(first, min(first + tile[0], beams)):  # whole rows, beam by beam: that vectorises
            cells = image[beam]
            for j in range(samples):
                highest[j] = cells[j] if cells[j] > highest[j] else highest[j]
        for begin in range(0, samples, tile[1]):
            crest = np.float32(0.0)
            for j in range(begin, min(begin + tile[1], samples)):
                crest = highest[j] if highest[j] > crest else crest
            if crest > np.float32(0.0):
                place = (float(crest) - background) / (noise * _BIN)
                row[begin // (tile[1] * _REGION), int(min(max(place, 0.0), most))] += 1


@kernel
def quantiles_around(histograms: Ints32) -> Floats:
    """Return (rows, columns, 2): the two quantiles of each region and those around it; (0, 0) where tiles are few."""
    rows, columns, bins = histograms.shape
    out = np.zeros((rows, columns, 2))
    total = np.empty(bins, np.int32)
    for i in range(rows):
        for j in range(columns):
            total[:] = 0
            for near in range(max(0, i - 1), min(rows, i + 2)):
                for beside in range(max(0, j - 1), min(columns, j + 2)):
                    for k in range(bins):
                        total[k] += histograms[near, beside, k]
            if total.sum() >= _LEAST_TILES:
                middle = _quantile(total, _MIDDLE, bins)
                out[i, j, 0] = _BIN * middle
                out[i, j, 1] = _BIN * _quantile(total, _UPPER, min(bins, int(_TOO_HIGH * middle) + 1))
    return out


@kernel
def _quantile(histogram: Ints32, share: float, bins: int) -> float:
    """Return the quantile of what is in the first bins, in bins, interpolated."""
    rank, below = share * histogram[:bins].sum(), 0
    for k in range(bins):
        if below + histogram[k] >= rank:
            return float(k + (rank - below) / max(1, histogram[k]))
        below += histogram[k]
    return float(bins)


@kernel
def shrink(image: Image, background: np.float32, factors: Image, region: tuple[int, int], out: Image) -> None:
    """Fill out with background + (image - background) * the factor (rows, columns) of the region."""
    beams, samples = image.shape
    along = np.empty(samples, np.float32)
    for first in range(0, beams, region[0]):
        row = factors[first // region[0]]
        for j in range(samples):
            along[j] = row[j // region[1]]
        for beam in range(first, min(first + region[0], beams)):
            _shrink_cells(image[beam], background, along, out[beam])


@kernel
def _shrink_cells(cells: Floats32, background: np.float32, factors: Floats32, out: Floats32) -> None:
    for j in range(cells.size):
        shrunk = background + (cells[j] - background) * factors[j]
        out[j] = cells[j] if factors[j] == np.float32(1.0) else shrunk


@kernel
def reaching(image: Image, runs: Runs, total: int, levels: Image, region: tuple[int, int]) -> Mask:
    """Tell (total,) which regions of runs have a cell above the level (rows, columns) of its region of the image."""
    found = np.zeros(total, np.bool_)
    for i in range(runs.shape[0]):
        beam, row = runs[i].beam, levels[runs[i].beam // region[0]]
        for column in range(runs[i].first, runs[i].stop):
            if image[beam, column] > row[column // region[1]]:
                found[runs[i].region - 1] = True
                break
    return found
