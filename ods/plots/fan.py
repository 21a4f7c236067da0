"""True fan pictures: a sonar image in metres, x across, y ahead, with detections on it.

Figures are made without pyplot, so nothing global is touched and no display is needed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Circle

from ods.base.arrays import Floats, Floats32
from ods.messages import Detection, Detections, Ping, seen_from_above
from ods.plots.polar import beam_edges, level_db
from ods.plots.style import MARK, STRONG, outline

PIXELS = 900
"""Of the longer side of a fan."""


class PolarImage(NamedTuple):
    """An image of one plane as the sonar has it."""

    level: Floats32
    """(beams, samples) dB."""
    bearing_rad: Floats
    """(beams,)"""
    range0_m: float
    """Of the first sample's centre."""
    dr_m: float

    def part(self, samples: int) -> "PolarImage":
        """Return its first `samples` samples."""
        return self._replace(level=self.level[:, :samples])


@dataclass(frozen=True)
class Raster:
    """A fan drawn on square pixels."""

    level: Floats32
    """(rows, columns), row 0 nearest to the sonar; NaN outside the fan."""
    extent: tuple[float, float, float, float]
    """Left, right, bottom, top, m."""


def polar_image(ping: Ping) -> PolarImage:
    """Return the image of a ping; of several planes the highest level.

    Raises ValueError when the ping's buffer does not fit its shape.
    """
    ping = seen_from_above(ping)
    beams = ping.beams // ping.planes
    level = level_db(ping).reshape(ping.planes, beams, ping.samples).max(axis=0)
    return PolarImage(level, np.array(ping.bearing_rad[:beams]), ping.range0_m, ping.dr_m)


def rasterize(image: PolarImage, pixels: int = PIXELS) -> Raster:
    """Turn a polar image into a Cartesian one whose longer side has `pixels` pixels.

    Every pixel shows the beam and the range that it lies in. Where several samples or beams fall into one pixel it
    shows the highest, so that small echoes stay visible.
    """
    level, bearing, range0_m, dr_m = image
    edges = beam_edges(bearing)
    far = range0_m + (level.shape[1] - 0.5) * dr_m
    arc = np.linspace(edges[0], edges[-1], 181)
    left, right = min(0.0, far * np.sin(arc).min()), max(0.0, far * np.sin(arc).max())
    bottom, top = min(0.0, far * np.cos(arc).min()), max(0.0, far * np.cos(arc).max())
    size = max(right - left, top - bottom) / pixels
    x = left + (np.arange(max(1, round((right - left) / size))) + 0.5) * size
    y = bottom + (np.arange(max(1, round((top - bottom) / size))) + 0.5) * size
    raster = _look_up(image._replace(level=_pool(level, max(1, round(size / dr_m)))), x, y)
    crowded = int(np.clip((size / np.diff(edges).min() - range0_m) / dr_m, 0, level.shape[1]))
    if crowded:  # so near, beams are finer than pixels
        _keep_highest(raster, image.part(crowded), (left, bottom, size))
    return Raster(raster, (left, left + len(x) * size, bottom, bottom + len(y) * size))


def _pool(level: Floats32, window: int) -> Floats32:
    """Return the highest of `window` neighbouring range samples around each one, same shape."""
    padded = np.pad(level, ((0, 0), (window // 2, (window - 1) // 2)), mode="edge")
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, window, axis=1).max(axis=-1))


def _look_up(image: PolarImage, x: Floats, y: Floats) -> Floats32:
    """Return the value of the cell at each pixel's centre, (len(y), len(x)); NaN half a pixel or more outside the
    fan."""
    level, bearing, range0_m, dr_m = image
    edges = beam_edges(bearing)
    across, ahead = np.meshgrid(x, y)
    beam = np.searchsorted(edges, np.arctan2(across, ahead)) - 1
    sample = np.rint((np.hypot(across, ahead) - range0_m) / dr_m).astype(np.int64)
    nearest = np.clip(sample, 0, level.shape[1] - 1)
    inside = (beam >= 0) & (beam < level.shape[0]) & (np.abs(sample - nearest) * dr_m <= 0.5 * (x[-1] - x[0]) / len(x))
    raster = np.full(across.shape, np.nan, np.float32)
    raster[inside] = level[beam[inside], nearest[inside]]
    return raster


def _keep_highest(raster: Floats32, image: PolarImage, grid: tuple[float, float, float]) -> None:
    """Raise each pixel to the highest of the cells whose centres lie in it, in place; grid: left, bottom, size."""
    level, bearing, range0_m, dr_m = image
    left, bottom, size = grid
    distance = range0_m + dr_m * np.arange(level.shape[1])
    column = np.floor((np.sin(bearing)[:, None] * distance - left) / size).astype(np.int64)
    row = np.floor((np.cos(bearing)[:, None] * distance - bottom) / size).astype(np.int64)
    place = np.clip(row, 0, raster.shape[0] - 1) * raster.shape[1] + np.clip(column, 0, raster.shape[1] - 1)
    highest = np.full(raster.size, -np.inf, np.float32)
    np.maximum.at(highest, place.ravel(), level.ravel())
    np.fmax(raster, highest.reshape(raster.shape), out=raster, where=np.isfinite(highest.reshape(raster.shape)))


def new_figure(title: str, bearing_rad: Floats) -> tuple[Figure, Axes]:
    """Return a figure with one pair of axes, of a shape that suits a fan of these bearings."""
    across, ahead = _size(bearing_rad)
    scale = min(8.0 / ahead, 11.0 / across)
    size = (max(2.4, scale * across) + 2.2, max(3.0, scale * ahead) + 0.9)
    figure = Figure(figsize=size, dpi=120, layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(title, fontsize=12)
    return figure, axes


def aspect_of(bearing_rad: Floats) -> float:
    """Return how many times as wide as high a fan of these bearings is."""
    across, ahead = _size(bearing_rad)
    return across / ahead


def _size(bearing_rad: Floats) -> tuple[float, float]:
    """Return width and height of a fan of radius 1 with its apex."""
    edges = beam_edges(bearing_rad)
    arc = np.linspace(edges[0], edges[-1], 181)
    across = max(0.0, float(np.sin(arc).max())) - min(0.0, float(np.sin(arc).min()))
    return across, max(0.0, float(np.cos(arc).max())) - min(0.0, float(np.cos(arc).min()))


def draw_fan(
    axes: Axes,
    image: PolarImage,
    *,
    limits_db: tuple[float, float] | None = None,
    label: str = "level, dB",
    pixels: int = PIXELS,
) -> None:
    """Draw an image as the fan it is, with range rings and a colour scale.

    limits_db: ends of the colour scale; without them those of `limits_of`.
    """
    picture = draw_fan_image(axes, image, limits_db or limits_of(image, pixels), pixels)
    style_colour_bar(axes.figure.colorbar(picture, ax=axes, shrink=0.75, pad=0.02), label)


def limits_of(image: PolarImage, pixels: int = PIXELS) -> tuple[float, float]:
    """Return the 5 % and 99.9 % quantiles of a fan's pixels, dB."""
    raster = rasterize(image, pixels).level
    shown = raster[np.isfinite(raster)]
    return float(np.quantile(shown, 0.05)), float(np.quantile(shown, 0.999))


def draw_fan_image(axes: Axes, image: PolarImage, limits_db: tuple[float, float], pixels: int = PIXELS) -> AxesImage:
    """Draw an image as a fan with range rings; return the artist for a colour scale."""
    raster = rasterize(image, pixels)
    low, high = limits_db
    picture = axes.imshow(
        raster.level,
        extent=raster.extent,
        origin="lower",
        vmin=low,
        vmax=max(high, low + 1.0),
        interpolation="nearest",
        aspect="equal",
    )
    _draw_rings(axes, beam_edges(image.bearing_rad), image.range0_m + image.dr_m * image.level.shape[1])
    _dress(axes)
    return picture


def style_colour_bar(bar: Colorbar, label: str) -> None:
    """Give a colour scale its label, and no frame."""
    bar.set_label(label)
    bar.outline.set_visible(False)


def _draw_rings(axes: Axes, borders: Floats, far_m: float) -> None:
    """Draw arcs at round ranges and the edges of the sector."""
    step = _round_step(far_m / 6.0)
    arc = np.linspace(borders[0], borders[-1], 121)
    for distance in np.arange(step, far_m, step):
        axes.plot(distance * np.sin(arc), distance * np.cos(arc), color=STRONG, lw=0.5, alpha=0.35)
        axes.annotate(
            f"{distance:g} m",
            (distance * np.sin(borders[-1]), distance * np.cos(borders[-1])),
            xytext=(4, -4),
            textcoords="offset points",
            fontsize=8,
        )
    for edge in (borders[0], borders[-1]):
        axes.plot([0.0, far_m * np.sin(edge)], [0.0, far_m * np.cos(edge)], color=STRONG, lw=0.5, alpha=0.35)


def _round_step(rough: float) -> float:
    """Return the nearest of 1, 2 and 5 times a power of ten that is not below `rough`."""
    power = 10.0 ** np.floor(np.log10(rough))
    return float(next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= rough * (1.0 - 1e-9)))


def _dress(axes: Axes) -> None:
    axes.set_xlabel("across, m (starboard right)")
    axes.set_ylabel("ahead, m")


def draw_detections(axes: Axes, detections: Sequence[Detection], *, colour: str = MARK, numbers: bool = True) -> None:
    """Draw the circles that stand for the detections, numbered from 1 in their order, with dots for centres."""
    for number, detection in enumerate(detections, 1):
        x = detection.range_m * np.sin(detection.bearing_rad)
        y = detection.range_m * np.cos(detection.bearing_rad)
        circle = Circle((x, y), detection.radius_m, fill=False, ec=colour, lw=1.4)
        circle.set_path_effects(outline())
        axes.add_patch(circle)
        axes.plot([x], [y], ".", color=colour, ms=2.5)
        if numbers:
            offset = 0.71 * detection.radius_m
            axes.annotate(
                str(number), (x + offset, y + offset), xytext=(2, 2), textcoords="offset points", color=colour,
                fontsize=8, path_effects=outline(),
            )  # fmt: skip


def ping_figure(ping: Ping, detections: Detections, title: str = "") -> Figure:
    """Return the picture of one ping with its detections; of several planes the highest level is shown.

    Raises ValueError when the ping's buffer does not fit its shape.
    """
    heading = title or f"ping {ping.ping_number}: {len(detections.detections)} detections"
    image = polar_image(ping)
    figure, axes = new_figure(heading if detections.usable else f"{heading}, drop-out", image.bearing_rad)
    draw_fan(axes, image)
    draw_detections(axes, detections.detections)
    return figure
