"""Height fields of rough sea-beds: square facets over a grid of nodes, made from a seed or read from a file."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32
from ods.base.files.npz_file import load_npz

MAX_FACETS = 4_000_000
"""Facets of a field; a file with more is refused."""
FACETS_PER_CORRELATION = 4
"""Facets in one correlation length, where the number of facets is left open."""


class HeightField(NamedTuple):
    """Heights over a grid of nodes, joined by bilinear facets; the slopes at the nodes round off the facets."""

    nodes: Floats32
    """(rows + 1, columns + 1, 3): height above the mean plane, up positive, and its slopes; rows go along x (north)."""
    facet_m: float
    """Side of a facet."""
    corner_m: tuple[float, float]
    """x and y of node (0, 0)."""
    repeats: bool
    """True: a tile that goes on for ever; False: beyond its borders the border's height goes on."""
    scale_m: float
    """Correlation length of a Gaussian field that bends as much: sqrt(6) rms slope / rms curvature; inf for a plane."""
    slope: float
    """Rms slope, in each direction; 0 when all heights are alike."""


def seeded_field(seed: int, rms_m: float, correlation_m: float, facets: int, facet_m: float | None) -> HeightField:
    """Return a field of Gaussian heights with the correlation exp(-r^2 / correlation_m^2), mean 0, rms exactly `rms_m`.

    It repeats after `facets` facets of `facet_m`, by default a quarter of the correlation length.
    """
    side = correlation_m / FACETS_PER_CORRELATION if facet_m is None else facet_m
    noise = np.random.default_rng(seed).standard_normal((facets, facets))
    wave = 2.0 * np.pi * np.fft.fftfreq(facets, side)
    half = wave[: facets // 2 + 1]
    weight = np.exp(-0.125 * correlation_m**2 * (wave[:, None] ** 2 + half[None, :] ** 2))
    weight[0, 0] = 0.0
    tile = np.fft.irfft2(np.fft.rfft2(noise) * weight, s=(facets, facets))
    spread = float(tile.std())
    tile *= rms_m / spread if spread > 0.0 else 0.0
    closed = np.pad(tile, ((0, 1), (0, 1)), mode="wrap")
    return _field(closed, side, (0.0, 0.0), repeats=True)


def load_field(path: Path) -> HeightField:
    """Read a field from an .npz file: nodes `height_m` (rows, columns), `facet_m`, `north_m`, `east_m` of node (0, 0).

    Raises ValueError, one line that names the file, for one that cannot be read, is too large or holds bad numbers.
    """
    try:
        data = load_npz(path, most_bytes=16 * MAX_FACETS)
        if data["height_m"].dtype.kind not in "fiu":
            raise ValueError("height_m must hold numbers")
        height: Floats = data["height_m"].astype(np.float64)
        facet, north, east = (float(data[key]) for key in ("facet_m", "north_m", "east_m"))
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror or 'not an .npz file'}") from error
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    except (KeyError, TypeError) as error:
        raise ValueError(f"{path}: must hold height_m, facet_m, north_m and east_m ({error})") from error
    if height.ndim != 2 or min(height.shape) < 2:
        raise ValueError(f"{path}: height_m must have at least 2 x 2 nodes, not {height.shape}")
    if (height.shape[0] - 1) * (height.shape[1] - 1) > MAX_FACETS:
        raise ValueError(f"{path}: more than {MAX_FACETS} facets")
    if not (np.all(np.isfinite(height)) and math.isfinite(north) and math.isfinite(east) and 0.0 < facet < math.inf):
        raise ValueError(f"{path}: heights, north_m and east_m must be finite numbers, facet_m above 0")
    return _field(height, facet, (north, east), repeats=False)


def height_at(field: HeightField, x: float, y: float) -> float:
    """Return the height of the field at one place, m."""
    place = []
    for value, corner, nodes in zip((x, y), field.corner_m, field.nodes.shape[:2], strict=True):
        cells = (value - corner) / field.facet_m
        place.append(cells % (nodes - 1) if field.repeats else min(max(cells, 0.0), nodes - 1.0))
    i, j = (min(int(cells), nodes - 2) for cells, nodes in zip(place, field.nodes.shape[:2], strict=True))
    a, b = place[0] - i, place[1] - j
    corners = field.nodes[i : i + 2, j : j + 2, 0].astype(np.float64)
    return float(np.array([1.0 - a, a]) @ corners @ np.array([1.0 - b, b]))


def _field(height: Floats, facet_m: float, corner_m: tuple[float, float], repeats: bool) -> HeightField:
    slope = _rms([np.diff(height, axis=axis) / facet_m for axis in (0, 1)])
    bend = _rms([np.diff(height, 2, axis=axis) / facet_m**2 for axis in (0, 1)])
    scale = math.sqrt(6.0) * slope / bend if bend > 1e-9 else math.inf
    slopes = [_slope(height, axis, facet_m, repeats) for axis in (0, 1)]
    nodes = np.stack([height, *slopes], axis=-1).astype(np.float32)
    return HeightField(nodes, facet_m, corner_m, repeats, scale, slope)


def _slope(height: Floats, axis: int, facet_m: float, repeats: bool) -> Floats:
    """Return the slope at each node from its two neighbours."""
    if not repeats:
        return np.asarray(np.gradient(height, facet_m, axis=axis))
    tile = height[:-1, :-1]
    slope = (np.roll(tile, -1, axis) - np.roll(tile, 1, axis)) / (2.0 * facet_m)
    return np.pad(slope, ((0, 1), (0, 1)), mode="wrap")


def _rms(parts: list[Floats]) -> float:
    count = sum(part.size for part in parts)
    return math.sqrt(sum(float(np.sum(np.square(part))) for part in parts) / max(count, 1))
