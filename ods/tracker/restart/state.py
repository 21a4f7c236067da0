"""State of a tracker as plain bytes and numbers, which a killed one leaves to the next."""

import msgspec

from ods.messages import Obstacle
from ods.tracker.map.map_object import MapObject


class TracksState(msgspec.Struct, frozen=True):
    """The live objects."""

    unjudged_s: float
    tables: list[bytes]
    """As they lie in memory, an object a column: history, existence, and those of the observer."""


class ClutterState(msgspec.Struct, frozen=True):
    """The false alarms counted so far."""

    scans: int
    mean: float
    by_part: list[float]
    by_radius: list[float]


class PoseNoiseState(msgspec.Struct, frozen=True):
    """What is known of the noise of poses; see `PoseNoise`."""

    known: list[float]
    times_ns: list[int]


class TrackerState(msgspec.Struct, frozen=True):
    """All but the objects of the map."""

    t_ns: int | None
    scans: int
    tracks: TracksState
    clutter: ClutterState
    clutter_statistics: list[float]
    """See `ClutterStatistics`."""
    pose_noise: PoseNoiseState


class MapChanges(msgspec.Struct, frozen=True):
    """How the objects that belong in the map differ from a former whole."""

    put: list[MapObject]
    remove: list[int]


class Announced(msgspec.Struct, frozen=True):
    """An object that ended, and the number of lists that still report it."""

    obstacle: Obstacle
    left: int
