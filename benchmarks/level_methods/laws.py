"""Levels by region of an image, by laws fitted to its cells, and by a ring around each cell. Plain numpy.

As in `ods.pipeline.detect.crests`: the excess over the background is divided by the factor by which the level has to
be higher there to be reached as seldom as on speckle that went through the same stages. A fit's own tail of speckle at
the level says how seldom that is, so what a fit gets wrong of speckle does not count.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from itertools import islice

import numpy as np
from scipy.ndimage import convolve, uniform_filter
from scipy.special import gammainc, gammaincc, gammainccinv, gammaincinv, polygamma, psi
from scipy.stats import gamma

from ods.base.arrays import Floats, Image, Mask
from ods.pipeline.detect.noise import NoiseMeter
from ods.pipeline.detect.rise import Rise, levelled

Measured = tuple[float, float]
"""Background and noise of an image."""
GRID, LEAST_TILE, REGION = (16, 32), (2, 16), 4
"""As in `crests`: tiles across and along at most, least cells of one, tiles along the side of a region."""
TOO_HIGH, BY_CHANCE = 2.5, 1.12
"""Tiles that reach so many times as high as the middle one are objects'; factors below this are 1."""
LEARNT_IMAGES = 8
OVER = 1.5
"""Threshold of the generalised Pareto law, multiples of the noise over the background."""


class Law(ABC):
    """A law of the cells, fitted by region to sums of functions of them."""

    def __init__(self, shape: tuple[int, int]) -> None:
        tile = [max(-(-n // most), least) for n, most, least in zip(shape, GRID, LEAST_TILE, strict=True)]
        self._starts = [np.arange(0, n, size) for n, size in zip(shape, tile, strict=True)]
        self._region = REGION * tile[0], REGION * tile[1]
        self._speckle = np.empty(0)
        self._noise = 0.0

    def learn(self, images: Iterable[Image]) -> None:
        """Take in speckle that went through the same stages."""
        meter, sums, noises = NoiseMeter(), [], []
        for image in islice(images, LEARNT_IMAGES):
            measured = meter.background_and_noise(image)
            sums.append(self._by_tile(self.functions(image, measured)).sum(axis=(1, 2)))
            noises.append(measured[1] / measured[0])
        self._speckle, self._noise = np.mean(sums, axis=0), float(np.mean(noises))

    def levelled(self, image: Image, measured: Measured, level: float) -> Image:
        """Return image (beams, samples) with what lies over the background shrunk, as the module says."""
        background = measured[0]
        sums = self._around(self._by_tile(self.functions(image, measured)), self._free(image, background))
        factor = self.level(sums, measured, level) / level
        factor[~(factor >= BY_CHANCE)] = 1.0  # nan, too
        return levelled(image, Rise(background, factor, 1.0, 1.0, *self._region))

    @abstractmethod
    def functions(self, image: Image, measured: Measured) -> Floats:
        """Return what is summed, (functions, beams, samples); the first one counts the cells."""

    @abstractmethod
    def level(self, sums: Floats, measured: Measured, level: float) -> Floats:
        """Return what `level` is in each region, (rows, columns), both in multiples of the noise; `sums`: theirs."""

    def _by_tile(self, cells: Floats) -> Floats:
        return np.asarray(np.add.reduceat(np.add.reduceat(cells, self._starts[1], axis=2), self._starts[0], axis=1))

    def _free(self, image: Image, background: float) -> Mask:
        """Return (tile rows, tile columns), which tiles show no object."""
        highest = np.maximum.reduceat(np.maximum.reduceat(image, self._starts[1], axis=1), self._starts[0], axis=0)
        highest = highest - background
        free = np.ones(highest.shape, np.bool_)
        for i in range(0, highest.shape[0], REGION):
            for j in range(0, highest.shape[1], REGION):
                near = highest[max(0, i - REGION) : i + 2 * REGION, max(0, j - REGION) : j + 2 * REGION]
                part = np.s_[i : i + REGION, j : j + REGION]
                free[part] = highest[part] <= TOO_HIGH * np.median(near)
        return free

    def _around(self, tiles: Floats, free: Mask) -> Floats:
        """Return the sums in each region and the eight around it, (functions, rows, columns)."""
        steps = [np.arange(0, n, REGION) for n in free.shape]
        regions = np.add.reduceat(np.add.reduceat(tiles * free, steps[1], axis=2), steps[0], axis=1)
        return np.asarray(convolve(regions, np.ones((1, 3, 3)), mode="constant"))


class KLaw(Law):
    """K-distributed intensity: its shape from the second moment (K. D. Ward, Electronics Letters 17, 1981)."""

    _INVERSE = np.linspace(0.0, 4.0, 17)
    """1 / shape, of the table."""

    def __init__(self, shape: tuple[int, int]) -> None:
        super().__init__(shape)
        self._table: dict[float, Floats] = {}

    def functions(self, image: Image, measured: Measured) -> Floats:
        """Return 1, the intensity and its square."""
        intensity = (image / np.float32(measured[0])) ** 2
        return np.stack([np.ones_like(intensity), intensity, intensity**2])

    def level(self, sums: Floats, measured: Measured, level: float) -> Floats:
        """Return the level by the ratio of the moments to that of speckle."""
        if level not in self._table:
            self._table[level] = self._quantiles(level)
        mean, ratio = _moments(sums)
        inverse = np.clip(ratio / _moments(self._speckle)[1] - 1.0, 0.0, self._INVERSE[-1])
        amplitude = np.sqrt(mean * np.interp(inverse, self._INVERSE, self._table[level]))
        return np.asarray((amplitude - 1.0) * measured[0] / measured[1])

    def _quantiles(self, level: float) -> Floats:
        """Return the intensity of mean 1, for each 1 / shape, that is exceeded as seldom as the level by speckle."""
        mean, ratio = _moments(self._speckle)
        looks = 1.0 / (float(ratio) - 1.0)
        highest = (1.0 + level * self._noise) ** 2 / float(mean)
        wanted = max(float(gammaincc(looks, looks * highest)), 1e-300)
        at, texture = highest * np.geomspace(0.5, 60.0, 120), np.geomspace(1e-4, 60.0, 240)
        step = np.log(texture[1] / texture[0])
        exceeds = gammaincc(looks, looks * at / texture[:, None])
        found = [highest]
        for inverse in self._INVERSE[1:]:
            share = (gamma.pdf(texture, 1.0 / inverse, scale=inverse) * texture * step) @ exceeds
            found.append(float(np.exp(np.interp(-np.log(wanted), -np.log(share + 1e-300), np.log(at)))))
        return np.array(found)


def _moments(sums: Floats) -> tuple[Floats, Floats]:
    """Return the mean, and the second moment over its square."""
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = sums[1] / sums[0]
        return mean, sums[2] / sums[0] / mean**2


class GammaLaw(Law):
    """Generalised gamma amplitude by log-cumulants (H.-C. Li et al., IEEE JSTSP 5(3), 2011)."""

    _KAPPA = np.geomspace(0.05, 1e3, 400)
    _SKEW = polygamma(2, _KAPPA) ** 2 / polygamma(1, _KAPPA) ** 3

    def functions(self, image: Image, measured: Measured) -> Floats:
        """Return 1, the logarithm, its square and cube; all 0 where no data are."""
        held = image > 0.0
        log = np.log(np.where(held, image / np.float32(measured[0]), np.float32(1.0)))
        return np.stack([held.astype(np.float32), log, log**2, log**3])

    def level(self, sums: Floats, measured: Measured, level: float) -> Floats:
        """Return the level by the quantiles of both laws."""
        kappa, power, scale = self._fit(self._speckle)
        share = _gamma_tail(kappa, power, np.log(1.0 + level * self._noise) - scale)
        amplitude = _gamma_quantile(*self._fit(sums), float(np.maximum(share, 1e-300)))
        return np.asarray((amplitude - 1.0) * measured[0] / measured[1])

    def _fit(self, sums: Floats) -> tuple[Floats, Floats, Floats]:
        """Return kappa, the power, and the logarithm of the scale."""
        with np.errstate(invalid="ignore", divide="ignore"):
            mean, second, third = sums[1:] / sums[0]
            variance = second - mean**2
            skew = third - 3.0 * mean * second + 2.0 * mean**3
            kappa = np.interp(-(skew**2) / variance**3, -self._SKEW, self._KAPPA)
            power = -np.sign(skew) * np.sqrt(polygamma(1, kappa) / variance)
            return kappa, power, mean - (psi(kappa) - np.log(kappa)) / power


def _gamma_tail(kappa: Floats, power: Floats, log: Floats) -> Floats:
    """Return how often the logarithm over the scale exceeds `log`."""
    at = kappa * np.exp(power * log)
    return np.where(power > 0.0, gammaincc(kappa, at), gammainc(kappa, at))


def _gamma_quantile(kappa: Floats, power: Floats, scale: Floats, share: float) -> Floats:
    """Return the amplitude that is exceeded so often."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        at = np.where(power > 0.0, gammainccinv(kappa, share), gammaincinv(kappa, share))
        return np.asarray(np.exp(scale + np.log(at / kappa) / power))


class ParetoLaw(Law):
    """Generalised Pareto over a threshold, by moments (J. R. M. Hosking, J. R. Wallis, Technometrics 29, 1987).

    Its shape is taken to be 0 at least: bounded tails of smooth speckle would make levels beyond the bound impossible.
    """

    def functions(self, image: Image, measured: Measured) -> Floats:
        """Return 1, whether a cell is over the threshold, by how much, and that squared."""
        over = (image - np.float32(measured[0] + OVER * measured[1])) / np.float32(measured[1])
        above = over > 0.0
        over = np.where(above, over, np.float32(0.0))
        return np.stack([np.ones_like(over), above.astype(np.float32), over, over**2])

    def level(self, sums: Floats, measured: Measured, level: float) -> Floats:
        """Return the level of both tails."""
        share, shape, scale = _pareto(self._speckle)
        wanted = share * (1.0 + shape * (level - OVER) / scale) ** (-1.0 / shape)
        share, shape, scale = _pareto(sums)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(OVER + scale / shape * (np.maximum(share / wanted, 1.0) ** shape - 1.0))


def _pareto(sums: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the share over the threshold, shape and scale."""
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = sums[2] / sums[1]
        ratio = mean**2 / (sums[3] / sums[1] - mean**2)
        shape = np.clip(0.5 * (1.0 - ratio), 1e-6, 0.45)
        return sums[1] / sums[0], shape, mean * (1.0 - shape)


class Ring:
    """Contrast to the mean of a ring around each cell, in multiples of the spread there."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self._outer = shape[0] // 4 | 1, shape[1] // 8 | 1
        self._inner = self._outer[0] // 3 | 1, self._outer[1] // 3 | 1

    def learn(self, images: Iterable[Image]) -> None:
        """Nothing: its level on speckle is found by trying."""

    def levelled(self, image: Image, measured: Measured, level: float) -> Image:
        """Return background + noise * contrast, (beams, samples)."""
        background, noise = measured
        mean, square = self._of_ring(image), self._of_ring(image**2)
        spread = np.sqrt(np.maximum(square - mean**2, (0.1 * noise) ** 2))
        return np.asarray(background + noise * (image - mean) / spread, np.float32)

    def _of_ring(self, values: Image) -> Image:
        outer, inner = self._outer[0] * self._outer[1], self._inner[0] * self._inner[1]
        whole, part = uniform_filter(values, self._outer), uniform_filter(values, self._inner)
        return np.asarray((whole * outer - part * inner) / (outer - inner), np.float32)


LAWS: dict[str, type[Law] | type[Ring]] = {"k": KLaw, "gamma": GammaLaw, "pareto": ParetoLaw, "ring": Ring}
