"""Sonar images as the fans they are, in grey, without matplotlib.

The geometry is worked out once; a ping costs a look-up.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Bytes, Floats32
from ods.messages import Ping, frame_of, seen_from_above
from ods.plots.polar import beam_edges, decibels

PIXELS = 800
"""Of the longer side, at most."""
LOWEST, HIGHEST = 0.05, 0.999
"""Quantiles of the first image of a setting that are black and white."""
LEAST_SPAN_DB = 1.0


class Geometry(NamedTuple):
    """What decides which sample each pixel shows."""

    bearing_rad: tuple[float, ...]
    """Of one plane."""
    planes: int
    samples: int
    range0_m: float
    dr_m: float


class Shades(NamedTuple):
    """What decides which grey each sample gets."""

    setting: str
    dtype: str
    scale: str
    scale_factor: float


class FanRaster:
    """Draws the pings of a sonar; geometry and shades are made again when these change."""

    def __init__(self) -> None:
        self._geometry: Geometry | None = None
        self._view: _View
        self._shades: Shades | None = None
        self._limits_db = (0.0, 1.0)
        self._table: Bytes | None = None

    def image(self, ping: Ping) -> Bytes:
        """Return (rows, columns) grey levels, the farthest row first, port to the left, 0 outside the fan.

        Of several planes the highest level is shown. Raises ValueError for a ping that is no image.
        """
        ping = seen_from_above(ping)
        if ping.beams % ping.planes or len(ping.bearing_rad) != ping.beams:
            raise ValueError("its beams do not fit its planes")
        beams = ping.beams // ping.planes
        geometry = Geometry(tuple(ping.bearing_rad[:beams]), ping.planes, ping.samples, ping.range0_m, ping.dr_m)
        if geometry != self._geometry:
            self._view, self._geometry = _View(geometry), geometry
        frame = frame_of(ping).reshape(ping.planes, beams, ping.samples).max(axis=0)
        return self._view.draw(self._grey(self._view.pooled(frame), ping))

    def pixel(self, range_m: float, bearing_rad: float) -> tuple[float, float]:
        """Return column and row of a place in the last image."""
        return self._view.pixel(range_m, bearing_rad)

    @property
    def metres_a_pixel(self) -> float:
        """Of the last image; 0 before there was one."""
        return self._view.size_m if self._geometry else 0.0

    def _grey(self, frame: AnyArray, ping: Ping) -> Bytes:
        """Return the grey levels, 1 to 255, of some of a ping's samples."""
        shades = Shades(ping.setting, ping.dtype, ping.scale, ping.scale_factor)
        if shades != self._shades:
            level = decibels(frame[:: max(1, len(frame) // 64)], ping)
            level = level[np.isfinite(level)]
            low, high = np.quantile(level, (LOWEST, HIGHEST)).tolist() if level.size else (0.0, 0.0)
            if high - low < LEAST_SPAN_DB:  # a drop-out shows nothing of the images to come
                return np.ones(frame.shape, np.uint8)
            self._shades, self._limits_db, self._table = shades, (low, high), None
            if ping.dtype != "f4":
                self._table = self._shade(decibels(np.arange(256**frame.itemsize), ping))
        return self._table[frame] if self._table is not None else self._shade(decibels(frame, ping))

    def _shade(self, level: Floats32) -> Bytes:
        low, high = self._limits_db
        share = np.nan_to_num((level - low) / (high - low)).clip(0.0, 1.0)
        return np.asarray(1.0 + 254.0 * share).astype(np.uint8)


class _View:
    """Which sample each pixel shows."""

    def __init__(self, geometry: Geometry) -> None:
        """Raises ValueError where no fan can be drawn."""
        bearing = np.array(geometry.bearing_rad)
        far = geometry.range0_m + (geometry.samples - 0.5) * geometry.dr_m
        if far <= 0.0 or not np.isfinite(far) or (np.diff(bearing) <= 0.0).any():
            raise ValueError("its geometry is not a fan")
        edges = beam_edges(bearing)
        arc = np.linspace(edges[0], edges[-1], 181)
        self._left, right = min(0.0, far * np.sin(arc).min()), max(0.0, far * np.sin(arc).max())
        bottom, self._top = min(0.0, far * np.cos(arc).min()), max(0.0, far * np.cos(arc).max())
        self.size_m = max(right - self._left, self._top - bottom) / min(PIXELS, max(64, geometry.samples))
        self._pool = min(geometry.samples, max(1, int(self.size_m / geometry.dr_m)))
        range0_m, dr_m = geometry.range0_m + 0.5 * (self._pool - 1) * geometry.dr_m, self._pool * geometry.dr_m
        samples = geometry.samples // self._pool
        x = self._left + (np.arange(max(1, round((right - self._left) / self.size_m))) + 0.5) * self.size_m
        y = self._top - (np.arange(max(1, round((self._top - bottom) / self.size_m))) + 0.5) * self.size_m
        across, ahead = np.meshgrid(x, y)
        turn = np.arctan2(across, ahead)
        beam = np.searchsorted(edges, turn) - 1
        sample = np.rint((np.hypot(across, ahead) - range0_m) / dr_m).astype(np.int64)
        inside = (beam >= 0) & (beam < len(bearing)) & (sample >= 0) & (sample < samples)
        self._index = np.where(inside, beam * samples + sample, 0)
        self._outside = ~inside

    def pooled(self, frame: AnyArray) -> AnyArray:
        """Return the highest of the samples that fall into a pixel together, so that small echoes stay visible."""
        beams, samples = len(frame), frame.shape[1] // self._pool
        return np.asarray(frame[:, : samples * self._pool].reshape(beams, samples, self._pool).max(axis=2))

    def draw(self, grey: AnyArray) -> Bytes:
        picture = grey.ravel()[self._index]
        picture[self._outside] = 0
        return np.asarray(picture, np.uint8)

    def pixel(self, range_m: float, bearing_rad: float) -> tuple[float, float]:
        x, y = range_m * np.sin(bearing_rad), range_m * np.cos(bearing_rad)
        return float((x - self._left) / self.size_m), float((self._top - y) / self.size_m)
