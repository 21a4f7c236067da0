"""Clips of fan images, as DIDSON's software exports them, read as pings: the fan's geometry must be given."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np

from ods.base.arrays import Bytes, Floats, Mask
from ods.base.settings import NonNegative, Positive, Settings, unit
from ods.messages import Ping
from ods.sonar_link.files.avi import AviFrames
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence, recorded_ping
from ods.sonar_link.ping_builder import Geometry, make_beam_table, runs_where


class FanGeometry(Settings, frozen=True):
    """Where the fan lies in an image: pixels from the left and from the top, the sonar's axis pointing up."""

    apex_x_px: float
    """Column of the sonar, where the beams meet; it may lie outside of the image."""
    apex_y_px: float
    """Row of the sonar; below the image it is greater than the image's height."""
    pixels_per_m: Positive
    """Scale, pixels/m."""
    bearing_min_deg: Annotated[float, msgspec.Meta(gt=-180.0, lt=180.0)]
    """Port border of the fan, degrees, starboard positive."""
    bearing_max_deg: Annotated[float, msgspec.Meta(gt=-180.0, lt=180.0)]
    """Starboard border."""
    range_min_m: NonNegative
    """Nearest range that the fan shows."""
    range_max_m: Positive
    """Farthest range."""
    beams: Annotated[int, msgspec.Meta(ge=2, le=1024)] = 96
    """Beams to read the fan as."""
    samples: Annotated[int, msgspec.Meta(ge=2, le=16384)] = 512
    """Range samples of each."""
    scale: Literal["linear", "db"] = "db"
    """What brightness stands for."""
    db_per_count: Positive = 80.0 / 255.0
    """Decibels a step of brightness, with scale "db"."""
    sound_speed: Annotated[float, msgspec.Meta(ge=1300.0, le=1700.0), unit("m/s")] = 1500.0
    """m/s."""

    def __post_init__(self) -> None:
        if self.bearing_max_deg <= self.bearing_min_deg:
            raise ValueError(f"bearing_max_deg: must be greater than bearing_min_deg, {self.bearing_min_deg:g}")
        if self.range_max_m <= self.range_min_m:
            raise ValueError(f"range_max_m: must be greater than range_min_m, {self.range_min_m:g}")


class FanClipDecoder(Decoder):
    """Counts `corrupt_frames` and `truncated_frames`. Every clip has the signature, so the suffix shows nothing."""

    name = ".avi"
    signature = ((0, b"RIFF"), (8, b"AVI "))

    def __init__(self, fan: FanGeometry | None = None) -> None:
        """`fan`: the geometry of the images, without which a clip is recognized, but cannot be read."""
        self._fan = fan

    def read(self, path: Path) -> PingSequence:
        """Read a clip. Raises PingFileError."""
        if self._fan is None:
            raise PingFileError(f"{path}: a clip of images needs its fan geometry (--fan)")
        frames = AviFrames(path)
        rows, columns = _places(self._fan)
        inside = _inside(rows, columns, frames.shape)
        if not inside.any():
            height, width = frames.shape
            raise PingFileError(f"{path}: the fan lies outside the image of {width} x {height} pixels")
        try:
            geometry = _geometry(self._fan)
        except ValueError as error:
            raise PingFileError(f"{path}: {error}") from error

        no_data = runs_where(~inside)

        def ping(index: int) -> Ping:
            polar = sample_image(frames[index], rows, columns)
            t_ns = frames.places[index] * frames.period_ns
            return recorded_ping(polar, geometry, index, t_ns, no_data=no_data)

        return PingSequence(LazyPings(len(frames), ping), timed=frames.period_ns > 0, losses=frames.losses)


def _places(fan: FanGeometry) -> tuple[Floats, Floats]:
    """Return (beams, samples) rows and columns of the image where the samples lie."""
    bearing, distance = _bearings(fan), _ranges(fan)
    rows = fan.apex_y_px - fan.pixels_per_m * np.outer(np.cos(bearing), distance)
    columns = fan.apex_x_px + fan.pixels_per_m * np.outer(np.sin(bearing), distance)
    return rows, columns


def _geometry(fan: FanGeometry) -> Geometry:
    """Raises ValueError when the numbers do not fit each other."""
    return Geometry(
        table=make_beam_table(_bearings(fan), np.zeros(fan.beams)),
        range0_m=float(_ranges(fan)[0]),
        dr_m=(fan.range_max_m - fan.range_min_m) / fan.samples,
        sound_speed=fan.sound_speed,
        scale=fan.scale,
        scale_factor=fan.db_per_count if fan.scale == "db" else 1.0,
    )


def _bearings(fan: FanGeometry) -> Floats:
    """Return (beams,) the middle of each beam, rad."""
    bearing: Floats = np.radians(_middles(fan.bearing_min_deg, fan.bearing_max_deg, fan.beams))
    return bearing


def _ranges(fan: FanGeometry) -> Floats:
    """Return (samples,) the middle of each sample, m."""
    return _middles(fan.range_min_m, fan.range_max_m, fan.samples)


def _middles(begin: float, end: float, count: int) -> Floats:
    """Return the middles of `count` equal parts of begin to end."""
    middles: Floats = begin + (end - begin) / count * (np.arange(count, dtype=np.float64) + 0.5)
    return middles


def sample_image(image: Bytes, rows: Floats, columns: Floats) -> Bytes:
    """Return image (rows, columns) at the given places, of any shape, between its pixels' centres bilinearly.

    0 outside of the image.
    """
    inside = _inside(rows, columns, (image.shape[0], image.shape[1]))
    y, x = np.where(inside, rows, 0.0), np.where(inside, columns, 0.0)
    top, left = np.floor(y).astype(np.intp), np.floor(x).astype(np.intp)
    bottom, right = np.minimum(top + 1, image.shape[0] - 1), np.minimum(left + 1, image.shape[1] - 1)
    down, aside = y - top, x - left
    upper = image[top, left] * (1.0 - aside) + image[top, right] * aside
    lower = image[bottom, left] * (1.0 - aside) + image[bottom, right] * aside
    return np.where(inside, np.rint(upper * (1.0 - down) + lower * down), 0.0).astype(np.uint8)


def _inside(rows: Floats, columns: Floats, shape: tuple[int, int]) -> Mask:
    return (rows >= 0.0) & (rows <= shape[0] - 1.0) & (columns >= 0.0) & (columns <= shape[1] - 1.0)
