"""Made-up frames: Rayleigh speckle whose level depends on range, beam and place, discs, and shadows behind them."""

from typing import Literal, NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats, Floats32
from ods.messages import Ping

DR_M = 0.05
SECTOR_RAD = float(np.radians(90.0))
OBJECTS = 8
DTYPES: dict[int, Literal["u1", "u2"]] = {8: "u1", 16: "u2"}
FINE = 5
"""Directions a beam that discs are drawn in before the beams blur them."""


class Disc(NamedTuple):
    """An object."""

    range_m: float
    bearing_rad: float
    radius_m: float
    contrast_db: float
    """Over the mean level of its range."""


def made_up_ping(beams: int, samples: int, bits: int, seed: int) -> Ping:
    """Return a frame of linear amplitudes with 8 objects."""
    rng = np.random.default_rng(seed)
    intensity = _intensity(rng, beams, samples, _discs(rng, beams, samples))
    amplitude = np.sqrt(rng.standard_exponential(intensity.shape, np.float32) * intensity)
    counts: AnyArray = np.clip(np.rint(amplitude * (2**bits - 1)), 0, 2**bits - 1)
    return Ping(
        seq=0, ping_number=0, t_ns=0, t_rx_ns=0, utc_ns=0, beams=beams, samples=samples, dtype=DTYPES[bits],
        data=counts.astype(DTYPES[bits]).tobytes(), range0_m=0.5 * DR_M, dr_m=DR_M, sound_speed=1500.0,
        bearing_rad=_bearings(beams).tolist(),
    )  # fmt: skip


def _bearings(beams: int) -> Floats:
    return np.asarray((np.arange(beams) - 0.5 * (beams - 1)) * (SECTOR_RAD / beams))


def _discs(rng: np.random.Generator, beams: int, samples: int) -> list[Disc]:
    reach, bearings = samples * DR_M, _bearings(beams)
    return [
        Disc(
            rng.uniform(0.12, 0.95) * reach, rng.uniform(bearings[3], bearings[-4]), rng.uniform(0.4, 2.0),
            rng.uniform(8.0, 16.0),
        )
        for _ in range(OBJECTS)
    ]  # fmt: skip


def _level(samples: int) -> Floats:
    """Return the mean amplitude of each range, (samples,), of a full scale of 1."""
    range_m = (np.arange(samples) + 0.5) * DR_M
    share = np.maximum(range_m / (samples * DR_M) - 0.06, 0.0) / 0.18
    return np.asarray(0.035 + 0.14 * share * np.exp(1.0 - share) + 0.05 * np.exp(-range_m / 1.5))


def _texture(rng: np.random.Generator, beams: int, samples: int) -> Floats:
    """Return factors, (beams, samples), that change slowly from place to place: straight between drawn ones."""
    drawn: Floats = rng.standard_normal((max(4, beams // 4), max(8, samples // 120)))
    for axis, size in enumerate((beams, samples)):
        at = np.linspace(0.0, drawn.shape[axis] - 1.0, size)
        first = np.minimum(at.astype(int), drawn.shape[axis] - 2)
        part = np.expand_dims(at - first, 1 - axis)
        drawn = (1.0 - part) * drawn.take(first, axis) + part * drawn.take(first + 1, axis)
    return np.exp(0.12 * drawn)


def _intensity(rng: np.random.Generator, beams: int, samples: int, discs: list[Disc]) -> Floats32:
    """Return the mean intensity of each cell, (beams, samples)."""
    square = _level(samples) ** 2
    intensity = square * _texture(rng, beams, samples) ** 2
    bearings = _bearings(beams)
    for disc in discs:
        begin = int((disc.range_m + disc.radius_m) / DR_M) + 2
        shadowed = np.abs(bearings - disc.bearing_rad) < disc.radius_m / disc.range_m
        intensity[shadowed, begin : begin + int(1.5 * disc.radius_m / DR_M)] *= 0.15
    intensity += _blurred(_drawn(discs, square, beams))
    gain = np.exp(0.08 * rng.standard_normal(beams))
    return np.asarray(intensity * (gain**2)[:, None], np.float32)


def _drawn(discs: list[Disc], square: Floats, beams: int) -> Floats:
    """Return the discs' intensity, (FINE * beams, samples)."""
    range_m, bearing = (np.arange(len(square)) + 0.5) * DR_M, _bearings(FINE * beams)
    drawn = np.zeros((FINE * beams, len(square)))
    for disc in discs:
        away = range_m**2 + disc.range_m**2 - 2.0 * range_m * disc.range_m * np.cos(bearing[:, None] - disc.bearing_rad)
        inside = away < disc.radius_m**2
        drawn = np.maximum(drawn, inside * square * 10.0 ** (0.1 * disc.contrast_db))
    return drawn


def _blurred(drawn: Floats) -> Floats:
    """Return what beams of Gaussian directivity see, as wide as they are spaced: (beams, samples)."""
    offset = np.arange(-3 * FINE, 3 * FINE + 1)
    weight = np.exp(-0.5 * (offset * 2.355 / FINE) ** 2)
    padded = np.pad(drawn, ((3 * FINE, 3 * FINE), (0, 0)))
    centre = np.arange(len(drawn) // FINE) * FINE + FINE // 2 + 3 * FINE
    return np.asarray(sum(w * padded[centre + k] for k, w in zip(offset, weight / weight.sum(), strict=True)))
