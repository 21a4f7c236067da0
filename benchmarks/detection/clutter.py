"""Images without echoes, as sonars see them: speckle of so many looks, K-distributed, correlated, louder with range.

Amplitudes (beams, samples) of mean square 1, drawn by numpy alone, with no code of ODS.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter
from scipy.stats import gamma, norm

from ods.base.arrays import Floats, Mask

Clutter = Callable[[np.random.Generator, tuple[int, int]], Floats]


def looks(number: float) -> Clutter:
    """Return speckle whose intensity is the mean of so many independent ones."""
    return lambda rng, shape: np.sqrt(rng.gamma(number, 1.0 / number, shape))


def k_distributed(order: float, patch: tuple[float, float] = (0.0, 0.0), number: float = 1.0) -> Clutter:
    """Return speckle on a gamma distributed texture of shape `order` (K. D. Ward, Electronics Letters 17, 1981).

    patch: standard deviation, beams and samples, of the Gaussian that makes the texture smooth; (0, 0): new in each
    cell.
    """

    def draw(rng: np.random.Generator, shape: tuple[int, int]) -> Floats:
        if patch == (0.0, 0.0):
            texture = rng.gamma(order, 1.0 / order, shape)
        else:
            texture = np.interp(_smooth(rng, shape, patch), *_gamma_of_normal(order))
        return np.asarray(looks(number)(rng, shape) * np.sqrt(texture))

    return draw


def correlated(samples: float, beams: float = 0.0) -> Clutter:
    """Return speckle whose field is correlated by exp(-(d / samples)^2 / 2) over d samples; over beams likewise."""

    def draw(rng: np.random.Generator, shape: tuple[int, int]) -> Floats:
        patch = (beams / np.sqrt(2.0), samples / np.sqrt(2.0))
        return np.asarray(np.hypot(_smooth(rng, shape, patch), _smooth(rng, shape, patch)) / np.sqrt(2.0))

    return draw


def moving_mean(samples: int) -> Clutter:
    """Return speckle whose field is the mean of so many neighbours in range."""

    def draw(rng: np.random.Generator, shape: tuple[int, int]) -> Floats:
        sums = np.cumsum(rng.standard_normal((2, shape[0], shape[1] + samples)), axis=2)
        field = sums[:, :, samples:] - sums[:, :, :-samples]
        return np.asarray(np.hypot(field[0], field[1]) / np.sqrt(2.0 * samples))

    return draw


def trend(factor: float, clutter: Clutter) -> Clutter:
    """Return clutter whose amplitude grows from near to far, by `factor` in all: a wrong time-varied gain."""

    def draw(rng: np.random.Generator, shape: tuple[int, int]) -> Floats:
        gain = factor ** np.linspace(-0.5, 0.5, shape[1])
        return np.asarray(clutter(rng, shape) * gain / np.sqrt(np.mean(gain**2)))

    return draw


def with_objects(rng: np.random.Generator, amplitude: Floats, number: int) -> tuple[Floats, Mask]:
    """Return amplitudes (beams, samples) with objects in them, and the cells in and near one.

    They are ellipses of 1 to 3 beams by 30 to 70 samples, 9 to 20 dB over the mean, with speckle of their own: ten of
    them fill 0.7 % of 60 x 2000 cells, and with a filter's reach around it 1 %.
    """
    if number == 0:
        return amplitude, np.zeros(amplitude.shape, np.bool_)
    beams, samples = amplitude.shape
    shown, inside = amplitude.copy(), np.zeros(amplitude.shape, np.bool_)
    beam, sample = np.arange(beams)[:, None], np.arange(samples)
    for _ in range(number):
        middle = rng.uniform((0.05 * beams, 0.15 * samples), (0.95 * beams, 0.95 * samples))
        half = rng.uniform((0.6, 15.0), (1.6, 35.0))
        cells = ((beam - middle[0]) / half[0]) ** 2 + ((sample - middle[1]) / half[1]) ** 2 < 1.0
        level = 10.0 ** rng.uniform(0.45, 1.0)
        shown[cells & ~inside] = level * np.sqrt(rng.exponential(size=np.count_nonzero(cells & ~inside)))
        inside |= cells
    return shown, np.asarray(maximum_filter(inside, (5, 61)))


@cache
def _gamma_of_normal(order: float) -> tuple[Floats, Floats]:
    """Return at which quantile of a standard normal distribution lies which of a gamma distribution of mean 1."""
    at = np.linspace(-6.0, 6.0, 4001)
    return at, gamma.isf(norm.sf(at), order) / order


def _smooth(rng: np.random.Generator, shape: tuple[int, int], sigma: tuple[float, float]) -> Floats:
    """Return a Gaussian field of variance 1, smooth along both axes."""
    field = rng.standard_normal(shape)
    for axis, width in enumerate(sigma):
        if width > 0.0:
            pulse = np.zeros(2 * int(8 * width) + 3)
            pulse[len(pulse) // 2] = 1.0
            scale = np.sqrt(np.sum(gaussian_filter1d(pulse, width) ** 2))
            field = gaussian_filter1d(field, width, axis=axis, mode="wrap") / scale
    return field
