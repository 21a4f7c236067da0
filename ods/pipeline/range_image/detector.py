"""One range image in, its detections out."""

import math

import numpy as np

from ods.base.arrays import AnyArray, Indices, Mask
from ods.messages import Detection, Detections, LookedVolume, Ping, Pose, RangeGrid, Sector
from ods.pipeline.image.samples.recorded import RegionNumbers
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.range_image.bodies import detection_of, pieces_of
from ods.pipeline.range_image.bottom import bottom_of
from ods.pipeline.range_image.clusters import bodies_of
from ods.pipeline.range_image.points import RangePixels
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseEstimate

MOST_DETECTIONS = 512
"""The nearest are taken where there are more."""
BEARINGS, ELEVATIONS = 64, 16
"""Most directions for which the range of clear water is reported; fewer where there are fewer pixels."""


def detect_ranges(
    ping: Ping,
    frame: AnyArray,
    settings: PipelineSettings,
    pose: Pose | PoseEstimate | None,
    mask: RegionNumbers | None,
) -> Detections:
    """Return the detections of a range image, `frame` (bearings, elevations); number their pixels in `mask`.

    pose: the head's; without one the head counts as level. Raises PingError for an invalid ping.
    """
    grid = ping.range_grid
    assert grid is not None
    pixels = _pixels_of(ping, grid, frame, settings, pose)
    chosen = settings.range_image
    believed = bottom_of(pixels, chosen.bottom_m)
    bodies = bodies_of(pixels, pixels.wanted & ~believed, chosen.noise_m, chosen.least_pixels)
    for body in bodies:
        believed.ravel()[body] = True
    bodies = _nearest(pixels, bodies)
    pieces = [piece for body in bodies for piece in pieces_of(pixels, body, chosen.largest_m, chosen.least_pixels)]
    width = math.radians(settings.beam_width_deg)
    found: list[Detection] = []
    for number, piece in enumerate(_nearest(pixels, pieces), 1):
        found.append(detection_of(pixels, piece, grid.range_max_m, width))
        if mask is not None:
            mask.ravel()[piece] = number
    return Detections(
        seq=ping.seq,
        ping_number=ping.ping_number,
        t_ns=ping.t_ns,
        t_rx_ns=ping.t_rx_ns,
        utc_ns=ping.utc_ns,
        sound_speed=ping.sound_speed,
        sector=_sector_of(ping, grid, settings.min_range_m),
        detections=found,
        looked_volume=_looked_of(pixels, believed, grid.range_max_m),
    )


def _nearest(pixels: RangePixels, bodies: list[Indices]) -> list[Indices]:
    """Return bodies by their ranges, of too many the nearest ones."""
    flat = pixels.range_m.ravel()
    return sorted(bodies, key=lambda body: float(flat[body].min()))[:MOST_DETECTIONS]


def _sector_of(ping: Ping, grid: RangeGrid, min_range_m: float) -> Sector:
    """Return the region that a range image covers."""
    return Sector(
        range_min_m=min_range_m,
        range_max_m=grid.range_max_m,
        bearing_min_rad=ping.bearing_rad[0],
        bearing_max_rad=ping.bearing_rad[-1],
        half_vertical_rad=min(max(grid.elevation_rad[-1], 0.0), max(-grid.elevation_rad[0], 0.0)),
    )


def _pixels_of(
    ping: Ping, grid: RangeGrid, frame: AnyArray, settings: PipelineSettings, pose: Pose | PoseEstimate | None
) -> RangePixels:
    bearing, elevation = np.array(ping.bearing_rad), np.array(grid.elevation_rad)
    if bearing.shape + elevation.shape != frame.shape or frame.dtype.kind != "u":
        raise PingError(f"range image of {frame.shape} {frame.dtype} does not fit its directions")
    if not (np.all(np.diff(bearing) > 0.0) and np.all(np.diff(elevation) > 0.0)):
        raise PingError("bearing_rad, or elevation_rad, does not increase from pixel to pixel")
    if not (math.isfinite(grid.range_max_m) and settings.min_range_m < grid.range_max_m):
        raise PingError(f"range_max_m: {grid.range_max_m} is not beyond pipeline.min_range_m, {settings.min_range_m} m")
    range_m = frame.astype(np.float32) * np.float32(ping.dr_m)
    wanted = (range_m >= max(settings.min_range_m, 1e-6)) & (range_m <= np.float32(grid.range_max_m))
    return RangePixels(range_m, wanted, bearing, elevation, pose)


def _looked_of(pixels: RangePixels, believed: Mask, range_max_m: float) -> LookedVolume:
    """Return the range up to which nothing was received, in cells of directions.

    believed: (bearings, elevations) pixels whose echo counts, those of the bottom too.
    """
    clear = np.where(believed, pixels.range_m, np.float32(range_max_m))
    for axis, most in enumerate((BEARINGS, ELEVATIONS)):
        count = clear.shape[axis]
        cells = min(most, count)
        firsts = np.arange(cells) * count // cells
        clear = np.minimum.reduceat(clear, firsts, axis)
    elevation = pixels.elevation_rad
    return LookedVolume(
        bearings=clear.shape[0],
        elevations=clear.shape[1],
        elevation_min_rad=float(elevation[0]),
        elevation_max_rad=float(elevation[-1]),
        clear_m=clear.astype("<f4").tobytes(),
    )
