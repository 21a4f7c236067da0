"""Water that a range image showed to be empty, at the heights of the layer for which clearance is reported."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.messages import Sector
from ods.tracker.measurement.coverage.looked import ObservedRanges

NOISE_M = 0.1
"""Distance, m, by which an echo may be nearer than its range."""


class LayerSeen(NamedTuple):
    """Arrays of one shape, of places in the layer."""

    empty: Mask
    """The whole height of the layer was seen there, and nothing nearer in those directions, nor there."""
    received: Mask
    """An echo was received there, at the layer's height."""
    room_m: Floats
    """Height observed to be empty above and below the layer; below 0: part of the layer is not."""


def layer_seen(
    sector: Sector,
    looked: ObservedRanges,
    places: tuple[Floats, Floats, Floats],
    half_m: float,
    cell_m: float,
    turn_rad: float,
) -> LayerSeen:
    """Return what a ping showed at `places`, forward, starboard and down of the head, of a layer of +- `half_m` there.

    cell_m: spacing of the positions; turn_rad: by how much the head turned until the last echo was back: the borders
    are so uncertain.
    """
    forward, starboard, down = places
    across = np.hypot(forward, starboard)
    bearing = np.arctan2(starboard, forward)
    low, high = np.arctan2(-down - half_m, across), np.arctan2(-down + half_m, across)
    farthest = np.hypot(across, np.abs(down) + half_m)
    first, last = looked.bearings_rad[0] + turn_rad, looked.bearings_rad[1] - turn_rad
    in_fan = (bearing >= first) & (bearing <= last) & (farthest < sector.range_max_m) & (across > sector.range_min_m)
    lowest, highest = looked.elevations_rad
    nearest, room = _nearest_and_room(looked, bearing, farthest, across, (low, high))
    room = np.minimum(room, across * np.minimum(low - lowest, highest - high))
    within = in_fan & (low >= lowest) & (high <= highest)
    return LayerSeen(
        empty=within & (farthest + NOISE_M < nearest),
        received=in_fan & (np.abs(nearest - np.hypot(across, down)) <= cell_m),
        room_m=room,
    )


def _nearest_and_room(
    looked: ObservedRanges, bearing: Floats, farthest: Floats, across: Floats, layer: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Return the nearest echo at the layer's elevations, and the height from it to what is not seen to be empty, m."""
    count = looked.clear_m.shape[1]
    lowest, highest = looked.elevations_rad
    step = (highest - lowest) / count
    nearest, room = np.full(bearing.shape, math.inf), np.full(bearing.shape, math.inf)
    for number in range(count):
        bottom, top = lowest + number * step, lowest + (number + 1) * step
        clear_m = looked.nearest(bearing, np.full(bearing.shape, 0.5 * (bottom + top)))
        away = np.maximum(np.maximum(bottom - layer[1], layer[0] - top), 0.0)
        np.copyto(nearest, np.minimum(nearest, clear_m), where=away == 0.0)
        np.copyto(room, np.minimum(room, away * across), where=clear_m <= farthest + NOISE_M)
    return nearest, room
