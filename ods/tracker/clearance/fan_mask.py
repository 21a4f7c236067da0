"""Empty and occupied parts of a ping, over bearing and range in the frame of the head."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Bytes, Mask
from ods.messages import Detection, Sector, UnseenPart
from ods.tracker.measurement.scan import NOT_SWEPT
from ods.tracker.settings import MARGIN_SIGMAS

BEARINGS = RANGES = 128


class FanMask(NamedTuple):
    """(BEARINGS, RANGES) each, evenly spaced over the sector."""

    sector: Sector
    empty: Mask
    """It was insonified and processed, and nothing was detected there, nor nearer on the same bearing."""
    received: Mask
    """Something was received there."""

    def shown(self) -> Bytes:
        """Return (BEARINGS + 2, RANGES + 2) 1 where it is empty, 2 where something is, in a rim of nothing."""
        shown = np.zeros((BEARINGS + 2, RANGES + 2), np.uint8)
        shown[1:-1, 1:-1] = self.empty.view(np.uint8) | self.received.view(np.uint8) << 1
        return shown


def fan_mask(
    sector: Sector,
    processed_ranges_m: Sequence[tuple[float, float]],
    unseen: Sequence[UnseenPart],
    echoes: Sequence["Extent"],
    turn_rad: float = 0.0,
) -> FanMask | None:
    """Return what a ping showed; None if its sector is invalid.

    turn_rad: by how much the head turned until the last echo was back: the borders are so uncertain.
    """
    borders = sector.bearing_min_rad, sector.bearing_max_rad, sector.range_min_m, sector.range_max_m
    if not math.isfinite(sum(borders)) or borders[0] >= borders[1] or borders[2] >= borders[3]:
        return None
    empty = np.zeros((BEARINGS, RANGES), bool)
    received = np.zeros_like(empty)
    for near, far in processed_ranges_m or [(borders[2], borders[3])]:
        empty[:, _within(near, far, borders[2], borders[3], RANGES)] = True
    for part in unseen:
        # what was not swept is shown by the next ping: between the two no column is to be left that neither shows
        of_part = _middles_in if part.why == NOT_SWEPT else _touched
        bearings = of_part(part.bearing_min_rad, part.bearing_max_rad, borders[0], borders[1], BEARINGS)
        empty[bearings, _touched(part.range_min_m, part.range_max_m, borders[2], borders[3], RANGES)] = False
    for echo in echoes:
        low, high = echo.bearing_rad - echo.half_rad, echo.bearing_rad + echo.half_rad
        bearings = _touched(low, high, borders[0], borders[1], BEARINGS)
        ranges = _touched(echo.near_m, echo.far_m, borders[2], borders[3], RANGES)
        received[bearings, ranges] = True
        empty[bearings, ranges.start :] = False
    if not turn_rad < borders[1] - borders[0]:  # not known, or too much
        empty[:] = False
    edge = math.ceil(min(turn_rad / (borders[1] - borders[0]), 1.0) * BEARINGS) if turn_rad > 0.0 else 0
    empty[:edge] = empty[BEARINGS - edge :] = False
    return FanMask(sector, empty, received)


class Extent(NamedTuple):
    """Where an echo may be."""

    near_m: float
    far_m: float
    half_rad: float
    """Half its width."""
    bearing_rad: float
    elevation_rad: float


def extents_of(echoes: Sequence[Detection]) -> list[Extent]:
    """Return where echoes may be, without those that are no numbers."""
    return [each for each in map(_extent_of, echoes) if math.isfinite(sum(each))]


def _extent_of(echo: Detection) -> Extent:
    near = echo.near_m - MARGIN_SIGMAS * echo.sigma_near_m
    if not echo.sigma_near_m > 0.0:  # not reported
        near = echo.range_m - echo.radius_m - MARGIN_SIGMAS * echo.sigma_range_m
    far = max(echo.range_m + echo.radius_m, near + echo.range_extent_m)
    half = 0.5 * echo.bearing_extent_rad + MARGIN_SIGMAS * echo.sigma_bearing_rad
    return Extent(max(near, 0.0), far, min(half, math.pi), echo.bearing_rad, echo.elevation_rad)


def _touched(low: float, high: float, first: float, last: float, count: int) -> slice:
    """Return the cells of [first, last] that [low, high] touches; all for what is not a number."""
    if not math.isfinite(low + high):
        return slice(0, count)
    per = count / (last - first)
    return slice(_bounded(math.floor((low - first) * per), count), _bounded(math.ceil((high - first) * per), count))


def _middles_in(low: float, high: float, first: float, last: float, count: int) -> slice:
    """Return the cells of [first, last] whose middles are in [low, high]; all for what is not a number."""
    if not math.isfinite(low + high):
        return slice(0, count)
    per = count / (last - first)
    return slice(_bounded(round((low - first) * per), count), _bounded(round((high - first) * per), count))


def _within(low: float, high: float, first: float, last: float, count: int) -> slice:
    """Return the cells of [first, last] that lie in [low, high] as a whole; none for what is not a number."""
    if not math.isfinite(low + high):
        return slice(0, 0)
    per, slack = count / (last - first), 1e-9
    start, stop = math.ceil((low - first) * per - slack), math.floor((high - first) * per + slack)
    return slice(_bounded(start, count), _bounded(stop, count))


def _bounded(index: int, count: int) -> int:
    return min(max(index, 0), count)
