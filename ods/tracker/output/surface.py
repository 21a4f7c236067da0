"""Waves of the water's surface among the objects: many that move alike, each where the surface may be.

A sonar of one plane does not see heights, so that no single echo says whether it is a wave or a body that hangs below.
But waves come in numbers, run at the same velocity and far from each other, and only where the fan meets the surface.
What is known to hang lower than the clearance, is seen where the fan is below the surface, rests, or moves otherwise,
is none.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.base.clock import NS
from ods.base.frames.geometry import rotation_matrix
from ods.pose.buffer import PoseEstimate
from ods.tracker.existence import lifecycle
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import MARGIN_SIGMAS, REST, SurfaceSettings

LOBES = 2.0
"""Multiple of the half vertical opening to which waves are observed: the sides of the main lobe receive them, too."""
NEAREST_M = 10.0
"""Range, m, below which everything is reported."""
SLOWEST = 1.0
"""Waves that a sonar sees, longer than 0.6 m, run faster than this, m/s (c^2 = g length / 2 pi)."""
SPREAD = 0.25
"""Standard deviation of the waves' velocities about their mean, m/s, each of north and east."""
VAGUE = 0.7
"""A velocity known to no better, m/s, shows nothing."""
FEWEST, APART_M = 4, 20.0
"""Waves are at least this number of objects that move alike, the farthest two of them at least this far apart, m."""
REMEMBERED_S = 20.0
"""Time for which their velocity is remembered, s."""
ALIKE = 9.2
"""Squared distance, in standard deviations, of velocities that are alike: 99 % of them."""
GRACE_S = 3.0
"""Time for which a wave's track still counts as a wave, s: as waves leave the fan, their tracks stop, or jump to the
next one. Where waves are, or one object runs and as many as waves may run alike, the report of an object waits as long
for its velocity: the edge of the fan shows a wave that runs along it at one position."""
WAITS_FROM_M = 20.0
"""Range, m, below which it does not wait."""
STATIC_PROBABILITY = 0.9
"""Probability from which on an object counts as static; a wave at the edge of the fan seems to be up to 0.89."""


class View(NamedTuple):
    """Whence and when objects are looked at."""

    utc_ns: int
    head: PoseEstimate
    """Of the sonar, with the vehicle's velocity."""
    half_vertical: float
    """Of the fan, rad."""


class WaveFilter:
    """The waves among the objects, list by list: their velocity, and which objects have been taken for them."""

    def __init__(self, settings: SurfaceSettings) -> None:
        self._settings = settings
        self._velocity: Floats | None = None
        self._known_ns = 0
        self._until_ns: dict[int, int] = {}
        """Until when the objects of these ids count as waves where they are seen,"""
        self._met_ns: dict[int, int] = {}
        """and when all objects of the list before this one were first in a list."""

    def among(self, snapshot: Snapshot, view: View | None) -> Mask:
        """Return (n,) bool: objects that are waves; none where the pose is unknown."""
        if view is None or self._settings.list == "all":
            return np.zeros(len(snapshot), bool)
        low, high = heights(snapshot, view, self._settings)
        young = self._young(snapshot, view.utc_ns)
        if self._velocity is None and not self._until_ns and not high.any():
            return high
        distance = np.hypot(*(snapshot.position[:2] - view.head.position_ned[:2, None]))
        alike = self._alike(snapshot, high & runs(snapshot), view.utc_ns)
        unknown = high & ~runs(snapshot) & (has_vague_velocity(snapshot) | (snapshot.static < STATIC_PROBABILITY))
        if self._velocity is not None or (alike.any() and is_field(snapshot.take(alike | unknown))):
            self._count(snapshot.id[young & (alike | unknown) & (distance > WAITS_FROM_M)], view.utc_ns)
        if self._velocity is not None:
            self._count(snapshot.id[alike], view.utc_ns + round(GRACE_S * NS))
        self._forget(snapshot, view.utc_ns)
        return np.asarray(np.isin(snapshot.id, list(self._until_ns)) & (distance > NEAREST_M) & ~low)

    def _count(self, ids: Ints, until_ns: int) -> None:
        """Count the objects of these ids as waves where they are seen until then."""
        self._until_ns |= {i: max(until_ns, self._until_ns.get(i, 0)) for i in ids.tolist()}

    def _young(self, snapshot: Snapshot, utc_ns: int) -> Mask:
        """Return (n,) bool: active objects first reported less than `GRACE_S` ago."""
        self._met_ns = {i: self._met_ns.get(i, utc_ns) for i in snapshot.id.tolist()}
        age_ns = utc_ns - np.array(list(self._met_ns.values()), np.int64)
        return np.asarray((age_ns >= 0) & (age_ns < GRACE_S * NS) & (snapshot.state == lifecycle.ACTIVE))

    def _forget(self, snapshot: Snapshot, utc_ns: int) -> None:
        """Let those be waves no more that were seen after their time, that the map has, and that are gone."""
        live = snapshot.state != lifecycle.HIBERNATED
        seen_ns = dict(zip(snapshot.id[live].tolist(), snapshot.last_seen_utc_ns[live].tolist(), strict=True))
        self._until_ns = {
            i: until
            for i, until in self._until_ns.items()
            if i in seen_ns and seen_ns[i] <= until and until - utc_ns <= GRACE_S * NS
        }

    def _alike(self, snapshot: Snapshot, running: Mask, utc_ns: int) -> Mask:
        """Return (n,) bool: which of those `running` do so at the velocity of the waves, or of what may be some.

        Learns the velocity that most of them share, if they are waves.
        """
        groups = (running & (distances(snapshot, v) < ALIKE) for v in snapshot.velocity[:2, running].T)
        best = max(groups, key=np.sum, default=running)
        group = snapshot.take(best)
        fast = len(group) > 0 and bool(np.hypot(*_mean_velocity(group)) > SLOWEST)
        if fast and is_field(group):
            self._velocity, self._known_ns = _mean_velocity(group), utc_ns
        elif abs(utc_ns - self._known_ns) > REMEMBERED_S * NS:
            self._velocity = None
        if self._velocity is not None:
            return running & (distances(snapshot, self._velocity) < ALIKE)
        return best & fast


def is_field(snapshot: Snapshot) -> bool:
    """Return whether objects are enough, and far enough apart, to be waves."""
    return len(snapshot) >= FEWEST and float(np.hypot(*np.ptp(snapshot.position[:2], axis=1))) > APART_M


def runs(snapshot: Snapshot) -> Mask:
    """Return (n,) bool: objects that move with a known velocity."""
    return np.asarray(
        ~has_vague_velocity(snapshot) & (snapshot.static < REST) & (snapshot.state != lifecycle.HIBERNATED)
    )


def has_vague_velocity(snapshot: Snapshot) -> Mask:
    """Return (n,) bool: objects whose velocity is too uncertain to show anything."""
    return np.asarray(snapshot.sigma_velocity[:2].max(axis=0, initial=0.0) >= VAGUE)


def heights(snapshot: Snapshot, view: View, settings: SurfaceSettings) -> tuple[Mask, Mask]:
    """Return (n,) bool each: objects known to be deeper than the clearance, and those that may be at the surface.

    Heights are known by the main lobe. Where only its sides meet the surface, what they receive seems to be deeper.
    """
    elevation = np.abs(elevation_of_surface(snapshot, view, settings))
    lower = snapshot.position[2] - settings.down_m - settings.clearance_m
    low = (lower > MARGIN_SIGMAS * snapshot.sigma_position[2]) & (elevation < view.half_vertical)
    is_below = view.head.position_ned[2] > settings.down_m
    return low, (elevation < LOBES * view.half_vertical) & ~low & is_below


def elevation_of_surface(snapshot: Snapshot, view: View, settings: SurfaceSettings) -> Floats:
    """Return (n,) the elevation, rad, at which the sonar had the surface above each object when it was last seen."""
    age = np.maximum(view.utc_ns - snapshot.last_seen_utc_ns, 0) / NS
    place = (snapshot.position - snapshot.velocity * age).T
    place[:, 2] = settings.down_m
    head = view.head.position_ned - np.outer(age, view.head.velocity_ned)
    forward, starboard, down = ((place - head) @ rotation_matrix(view.head.attitude)).T
    return np.asarray(np.arctan2(-down, np.hypot(forward, starboard)))


def distances(snapshot: Snapshot, velocity: Floats) -> Floats:
    """Return (n,) squared distances of the objects' velocities from one, (2,), in standard deviations."""
    variance = snapshot.sigma_velocity[:2] ** 2 + SPREAD**2
    return np.asarray(((snapshot.velocity[:2] - velocity[:2, None]) ** 2 / variance).sum(axis=0))


def _mean_velocity(snapshot: Snapshot) -> Floats:
    weight = 1.0 / (snapshot.sigma_velocity[:2] ** 2 + SPREAD**2)
    return np.asarray((weight * snapshot.velocity[:2]).sum(axis=1) / weight.sum(axis=1))
