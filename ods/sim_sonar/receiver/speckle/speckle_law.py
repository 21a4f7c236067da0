"""The law of speckle: from the asked looks and correlations to tables and filters."""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.polynomial.hermite_e import hermegauss, hermeval
from scipy.optimize import brentq
from scipy.special import factorial, gammainc, gammaincc, gammainccinv, gammaincinv, ndtr, ndtri, roots_genlaguerre

from ods.base.arrays import Floats, Image
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.sonar.patterns import NODES_PER_WIDTH

TABLE_REACH = 6.0
"""Standard deviations of the normal variable that the table covers; one sample in 5e8 lies beyond."""
TABLE_NODES = 4097
TERMS = 24
"""Terms of the Hermite series."""
LAGUERRE_NODES = 64
FAINT = 1e-3
"""Correlation below which no filter is worth it."""


def speckle_amplitudes(looks: float, texture: float | None = None) -> Image:
    """Return sqrt(g) for normal quantiles even in +-TABLE_REACH, where g is Gamma distributed: mean 1, shape `looks`.

    looks = 1 is fully developed speckle: Rayleigh amplitude, exponential intensity. With a texture, itself Gamma
    distributed with that shape, g is K distributed.
    """
    return _amplitude(np.linspace(-TABLE_REACH, TABLE_REACH, TABLE_NODES), looks, texture).astype(np.float32)


def normal_correlation(amplitude_correlation: float, looks: float, texture: float | None = None) -> float:
    """Return the correlation of normal numbers whose speckle amplitudes are correlated as asked, 0 to 1.

    Source: the Hermite series of a function f of normal numbers, cov f(x) f(y) = sum of c_n^2 rho^n / n! for n > 0.
    """
    return _solve(amplitude_correlation, lambda normal: _amplitude(normal, looks, texture))


def frozen_correlation(looks: float, texture: float | None = None) -> Image:
    """Return what makes normal numbers of echo and noise together as correlated from ping to ping as they should be.

    Echo and noise add up as fields do: where the echo, the share f of the power, stays and the noise is fresh, fields
    are correlated as f and intensities as f^2 (J. W. Goodman, Speckle Phenomena in Optics, 2007, ch. 3). The numbers'
    correlation is then f^2 (1 + (1 - f) (a + b f + c f^2)); a, b, c, float32, are returned; intensities are right to
    4e-4.
    """
    share, normal = np.linspace(0.0, 1.0, 401), np.linspace(0.0, 1.0, 16001)
    intensity = _correlation_of(lambda x: _amplitude(x, looks, texture) ** 2, normal)
    excess = np.interp(share**2, intensity, normal) - share**2
    terms = (share**2 * (1.0 - share))[:, None] * share[:, None] ** np.arange(3)
    return np.asarray(np.linalg.lstsq(terms, excess, rcond=None)[0], np.float32)


def beam_overlap_correlation(sonar: SonarModel, looks: float, texture: float | None = None) -> float:
    """Return the correlation of normal numbers between neighbouring beams of `sonar`.

    Scatterers all around make the fields of two beams correlated as their patterns overlap, and intensities as the
    square of that (J. W. Goodman, Speckle Phenomena in Optics, 2007, ch. 5).
    """
    if len(sonar.plane_bearing_rad) < 2:
        return 0.0
    step = float(np.median(np.diff(sonar.plane_bearing_rad))) / sonar.beam_width_rad
    field = np.sqrt(np.diff(sonar.horizontal_cumulative) * NODES_PER_WIDTH)
    offset = np.arange(len(field)) / NODES_PER_WIDTH
    shared = float(field @ np.interp(offset - step, offset, field, left=0.0)) / float(field @ field)
    return _solve(shared**2, lambda normal: _amplitude(normal, looks, texture) ** 2)


def taps(correlation: float) -> Floats:
    """Return a Gaussian filter, odd length, that gives white noise this correlation from one sample to the next.

    The variance stays 1.
    """
    if correlation < FAINT:
        return np.ones(1)
    width = float(brentq(lambda w: _neighbours(_gaussian(w)) - correlation, 0.1, 10.0))
    return _gaussian(width)


def _gaussian(width: float) -> Floats:
    half = math.ceil(3.5 * width)
    values = np.exp(-0.5 * (np.arange(-half, half + 1) / width) ** 2)
    return np.asarray(values / np.linalg.norm(values))


def _neighbours(values: Floats) -> float:
    return float(values[1:] @ values[:-1])


def _amplitude(normal: Floats, looks: float, texture: float | None = None) -> Floats:
    if texture is not None:
        return np.asarray(np.exp(0.5 * np.interp(normal, *_textured(looks, texture))))
    lower, upper = gammaincinv(looks, ndtr(normal)), gammainccinv(looks, ndtr(-normal))
    return np.sqrt(np.where(normal < 0.0, lower, upper) / looks)


@lru_cache(maxsize=4)
def _textured(looks: float, texture: float) -> tuple[Floats, Floats]:
    """Return normal quantiles and the logarithms of K distributed intensities, mean 1, that they belong to.

    Source: E. Jakeman and P. N. Pusey, A model for non-Rayleigh sea echo, 1976: the mean is Gamma distributed.
    """
    mean, weight = roots_genlaguerre(LAGUERRE_NODES, texture - 1.0)
    mean, weight = mean / texture, weight / weight.sum()
    intensity = np.geomspace(1e-18, 1e4, TABLE_NODES)
    ratio = looks * intensity[:, None] / mean
    below, above = gammainc(looks, ratio) @ weight, gammaincc(looks, ratio) @ weight
    normal = np.where(below < 0.5, ndtri(below), -ndtri(above))
    real = np.isfinite(normal)
    return normal[real], np.log(intensity[real])


def _solve(wanted: float, function: Callable[[Floats], Floats]) -> float:
    if wanted < FAINT:
        return 0.0
    return float(brentq(lambda rho: float(_correlation_of(function, rho)) - min(wanted, 0.999), 0.0, 1.0))


def _correlation_of(function: Callable[[Floats], Floats], normal: float | Floats) -> Floats:
    """Return the correlation of `function` of normal numbers that have the correlations `normal`, 0 to 1."""
    nodes, weights = hermegauss(80)
    values = function(nodes) * weights / math.sqrt(2.0 * math.pi)
    orders = np.arange(1, TERMS)
    series = np.array([values @ hermeval(nodes, np.eye(TERMS)[n]) for n in orders]) ** 2 / factorial(orders)
    return np.asarray(np.power.outer(normal, orders) @ (series / series.sum()))
