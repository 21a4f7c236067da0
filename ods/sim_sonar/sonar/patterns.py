"""Beam patterns: sensitivity over the angle from a beam's axis, as tables for the image kernels."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ods.base.arrays import Floats

ELEVATION_NODES = 4097
"""Nodes of a vertical table, even in the sine of elevation: 0.03 degrees apart near the horizon."""
NODES_PER_WIDTH = 64
"""Nodes of the horizontal table in one beam width."""


def two_way_table(angle_deg: Sequence[float], level_db: Sequence[float], axis_rad: float) -> Floats:
    """Return S^2 of eq. 5 over sin(elevation): ELEVATION_NODES values, even from -1 to 1.

    `level_db` is S^2 in dB, emission and reception together, at `angle_deg` off the axis, which lies at elevation
    `axis_rad`.
    """
    elevation = np.arcsin(np.linspace(-1.0, 1.0, ELEVATION_NODES))
    off_axis_deg = np.degrees(np.abs(elevation - axis_rad))
    return np.asarray(10.0 ** (np.interp(off_axis_deg, angle_deg, level_db) / 10.0), np.float64)


def aperture_table(wavelengths: float, axis_rad: float) -> Floats:
    """Return the same for an evenly lit aperture `wavelengths` high that sends and receives: sinc^4(L sin(angle))."""
    elevation = np.arcsin(np.linspace(-1.0, 1.0, ELEVATION_NODES))
    return np.asarray(np.sinc(wavelengths * np.sin(elevation - axis_rad)) ** 4, np.float64)


def horizontal_power(offset: ArrayLike, side_lobe_db: float) -> Floats:
    """Return the horizontal intensity pattern at `offset` beam widths off the axis: 1 on it, 0.5 at +-0.5.

    It is that of a line array with a Kaiser-Bessel taper chosen for the asked side-lobe level (at most -13.3 dB):
    E(u) = sin(sqrt(u^2 - B^2)) / sqrt(u^2 - B^2), whose highest side lobe lies 13.26 dB + 20 log10(sinh(B) / B) down.
    """
    taper = _taper(side_lobe_db)
    peak = math.sinh(taper) / taper
    edge = _root(lambda u: float(_field(np.asarray(u), taper)) / peak - math.sqrt(0.5), 0.0, math.hypot(taper, math.pi))
    return np.square(_field(np.asarray(offset, np.float64) * 2.0 * edge, taper) / peak)


def horizontal_cumulative(side_lobe_db: float, widest: float) -> Floats:
    """Return the running integral of `horizontal_power` from -widest to +widest, NODES_PER_WIDTH nodes a beam width."""
    nodes = 2 * math.ceil(widest * NODES_PER_WIDTH) + 1
    offset = (np.arange(nodes) - nodes // 2) / NODES_PER_WIDTH
    power = horizontal_power(offset, side_lobe_db)
    steps = 0.5 * (power[1:] + power[:-1]) / NODES_PER_WIDTH
    return np.concatenate([[0.0], np.cumsum(steps)])


def _taper(side_lobe_db: float) -> float:
    ratio = 10.0 ** ((-side_lobe_db - 13.26) / 20.0)
    if ratio <= 1.0 + 1e-6:
        return 1e-3
    return _root(lambda b: math.sinh(b) / b - ratio, 1e-3, 12.0)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq  # 40 MB: only where a sonar is built

    return float(brentq(function, low, high))


def _field(u: Floats, taper: float) -> Floats:
    square = u * u - taper * taper
    root = np.maximum(np.sqrt(np.abs(square)), 1e-9)
    inner = np.sinh(np.minimum(root, taper))
    return np.asarray(np.where(square > 0.0, np.sin(root), inner) / root)
