"""From the pixels of a body to its circle, with height, and how well both are known."""

import math

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.messages import Detection
from ods.pipeline.measure.circle.enclosing_circle import smallest_circle
from ods.pipeline.range_image.points import RangePixels

SIGMA_RANGE_M = 0.03
"""Of a pixel."""
SHAPE_SHARE = 0.25
"""Of the radius: what a front does not show of where the middle is, and how large the circle is."""
OUTLIERS = 0.03
"""So large a share of the pixels at either end of its ranges are not believed."""
FEWEST_FITTED = 10
"""Number of pixels that suffice to measure the curvature of a leading edge."""


def pieces_of(pixels: RangePixels, body: Indices, largest_m: float, fewest: int) -> list[Indices]:
    """Return the pixels of a body, or, where its circle would be larger, of its pieces in square cells of the world."""
    level = pixels.points_ned.reshape(-1, 3)[body, :2]
    if smallest_circle(np.ascontiguousarray(level))[2] <= largest_m:
        return [body]
    cells = np.floor(level / (math.sqrt(2.0) * largest_m)).astype(np.int64)
    _, cell = np.unique(cells, axis=0, return_inverse=True)
    order = np.argsort(cell.reshape(-1), kind="stable")
    borders = np.flatnonzero(np.diff(cell.reshape(-1)[order])) + 1
    return [body[part] for part in np.split(order, borders) if part.size >= fewest]


def detection_of(pixels: RangePixels, body: Indices, range_max_m: float, beam_width_rad: float) -> Detection:
    """Return the circle of a body's pixels.

    Its elevation is that of the middle of what is seen of it. A body that the upper or lower border cuts off may go on
    there: its middle is anywhere in what is seen.
    """
    sure = _without_outliers(pixels, body)
    columns, rows = np.unravel_index(sure, pixels.range_m.shape)
    distances = pixels.range_m.ravel()[sure]
    points = pixels.points_ned.reshape(-1, 3)[sure]
    north, east, radius = smallest_circle(np.ascontiguousarray(points[:, :2]))
    top, bottom = float(points[:, 2].min()), float(points[:, 2].max())
    range_m, bearing, elevation = pixels.to_polar(np.array([north, east, 0.5 * (top + bottom)]))
    near_m = float(distances.min())
    roundness = _roundness(points - pixels.position, radius)
    range_m += roundness * max(0.0, near_m + radius - range_m)  # a round body begins a radius before its middle
    across, up = pixels.spacing_rad
    width = beam_width_rad or 2.0 * across
    is_cut = _touches(columns, pixels.bearing_rad) or float(distances.max()) > 0.995 * range_max_m
    shape = (2.0 if is_cut else 1.0) * SHAPE_SHARE * radius
    return Detection(
        range_m=range_m,
        bearing_rad=bearing,
        radius_m=radius,
        peak=0.0,
        mean=0.0,
        snr_db=0.0,
        cells=int(body.size),
        range_extent_m=float(np.ptp(distances)),
        bearing_extent_rad=float(np.ptp(pixels.bearing_rad[columns])) + across,
        sigma_range_m=math.hypot(SIGMA_RANGE_M, shape),
        sigma_bearing_rad=math.hypot(0.25 * width, (shape if is_cut else 0.5 * shape) / range_m),
        sigma_radius_m=math.hypot(SIGMA_RANGE_M + 0.25 * width * range_m, shape),
        elevation_rad=elevation,
        near_m=near_m,
        sigma_near_m=SIGMA_RANGE_M,
        cut=is_cut,
        elevation_extent_rad=float(np.ptp(pixels.elevation_rad[rows])) + up,
        sigma_elevation_rad=_sigma_elevation(pixels, rows, (bottom - top) / range_m),
    )


def _without_outliers(pixels: RangePixels, body: Indices) -> Indices:
    """Return the pixels of a body without the few nearest and farthest ones, which may be noise beside it."""
    order = np.argsort(pixels.range_m.ravel()[body], kind="stable")
    skipped = int(OUTLIERS * body.size)
    return body[order[skipped : body.size - skipped]]


def _roundness(seen: Floats, radius: float) -> float:
    """Return how round the front of a body is: 1 as a circle of its radius, 0 flat, however it is turned.

    seen: (n, 3) points from the head, level. Their distance is fitted by a parabola across and one up: across a circle
    it grows by the square over its diameter.
    """
    if len(seen) < FEWEST_FITTED:
        return 0.5
    level = np.hypot(seen[:, 0], seen[:, 1])
    azimuth = np.arctan2(seen[:, 1], seen[:, 0])
    middle = np.arctan2(np.sin(azimuth).sum(), np.cos(azimuth).sum())
    across = level * np.sin(azimuth - middle)
    up = seen[:, 2] - seen[:, 2].mean()
    matrix = np.column_stack([np.ones(len(seen)), across, np.square(across), up, np.square(up)])
    bend = float(np.linalg.lstsq(matrix, seen[:, :2] @ [np.cos(middle), np.sin(middle)], rcond=None)[0][2])
    return min(max(2.0 * radius * bend, 0.0), 1.0)


def _sigma_elevation(pixels: RangePixels, rows: Indices, extent_rad: float) -> float:
    """Return the standard deviation of the elevation of a body's middle."""
    up = pixels.spacing_rad[1]
    if _touches(rows, pixels.elevation_rad):
        return math.hypot(up, extent_rad / math.sqrt(12.0))  # anywhere in what is seen
    return math.hypot(up, 0.1 * extent_rad)


def _touches(places: Indices, angles: Floats) -> bool:
    return bool(places.min() == 0 or places.max() == angles.size - 1)
