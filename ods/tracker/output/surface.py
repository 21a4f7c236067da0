"""Waves of the water's surface among the objects: many that move alike, each where the surface may be.

A sonar of one plane does not see heights, so that no single echo says whether it is a wave or a body that hangs below.
But waves come in numbers, run at the same velocity and far from each other, and only where the fan meets the surface.
What is known to hang lower than the clearance, is seen where the fan is below the surface, rests, or moves otherwise,
is none.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
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
SUSPECTS = 3
"""Least number that may be waves, even side by side."""
REMEMBERED_S = 20.0
"""Time for which their velocity is remembered, s."""
ALIKE = 9.2
"""Squared distance, in standard deviations, of velocities that are alike: 99 % of them."""
GRACE_S = 3.0
"""Time for which a wave's track still counts as a wave, s: as waves leave the fan, their tracks stop, or jump to the
next one. The report of an object that may move with unknown velocity waits as long where waves are known: the edge of
the fan shows a wave that runs along it at one position."""
YOUNG_S, YOUNG_M = 1.0, 20.0
"""Where waves are or may be, an object farther away than this, m, that may move is reported this time, s, after it was
confirmed: by then its motion is known, and whether others move alike."""
RESTS = 0.8
"""Probability from which on an object counts as static."""


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
        high = may_be_at_surface(snapshot, view, self._settings)
        young = self._young(snapshot, view.utc_ns, YOUNG_S)
        if self._velocity is None and not self._until_ns and not high.any():
            return high
        running = runs(snapshot)
        suspected = self._learn(snapshot.take(np.flatnonzero(running & high)), view.utc_ns)
        waits = np.zeros(len(snapshot), bool)
        if suspected is not None:
            alike = running & high & (distances(snapshot, suspected) < ALIKE)
            may_run = high & ~running & (vague(snapshot) | (snapshot.static < RESTS))
            waits = young & (alike | may_run)
            if self._velocity is not None:
                waits |= self._young(snapshot, view.utc_ns, GRACE_S) & may_run
                self._until_ns |= dict.fromkeys(snapshot.id[alike].tolist(), view.utc_ns + round(GRACE_S * NS))
        self._forget(snapshot, view.utc_ns)
        distance = np.hypot(*(snapshot.position[:2] - view.head.position_ned[:2, None]))
        waves = np.isin(snapshot.id, list(self._until_ns)) & (distance > NEAREST_M)
        waves |= waits & (distance > YOUNG_M)
        return np.asarray(waves & ~hangs_low(snapshot, self._settings))

    def _young(self, snapshot: Snapshot, utc_ns: int, age_s: float) -> Mask:
        """Return (n,) bool: active objects first reported less than `YOUNG_S` ago."""
        self._met_ns = {i: self._met_ns.get(i, utc_ns) for i in snapshot.id.tolist()}
        age_ns = utc_ns - np.array(list(self._met_ns.values()), np.int64)
        return np.asarray((age_ns >= 0) & (age_ns < age_s * NS) & (snapshot.state == lifecycle.ACTIVE))

    def _forget(self, snapshot: Snapshot, utc_ns: int) -> None:
        """Let those be waves no more that were seen after their time, that the map has, and that are gone."""
        live = snapshot.state != lifecycle.HIBERNATED
        seen_ns = dict(zip(snapshot.id[live].tolist(), snapshot.last_seen_utc_ns[live].tolist(), strict=True))
        self._until_ns = {
            i: until
            for i, until in self._until_ns.items()
            if seen_ns.get(i, until) < until and until - utc_ns <= GRACE_S * NS
        }

    def _learn(self, candidates: Snapshot, utc_ns: int) -> Floats | None:
        """Take the velocity that most of the candidates share, if they are waves.

        Return the velocity of the waves, or else of what may be some; None: there are none.
        """
        suspected = None
        best = max((distances(candidates, v) < ALIKE for v in candidates.velocity[:2].T), key=np.sum, default=None)
        if best is not None:
            velocity = _mean_velocity(candidates.take(best))
            if best.sum() >= SUSPECTS and np.hypot(*velocity) > SLOWEST:
                suspected = velocity
                if best.sum() >= FEWEST and _extent(candidates.take(best)) > APART_M:
                    self._velocity, self._known_ns = velocity, utc_ns
        if abs(utc_ns - self._known_ns) > REMEMBERED_S * NS:
            self._velocity = None
        return suspected if self._velocity is None else self._velocity


def runs(snapshot: Snapshot) -> Mask:
    """Return (n,) bool: objects that move with a known velocity."""
    return np.asarray(~vague(snapshot) & (snapshot.static < REST) & (snapshot.state != lifecycle.HIBERNATED))


def vague(snapshot: Snapshot) -> Mask:
    """Return (n,) bool: objects whose velocity is too uncertain to show anything."""
    return np.asarray(snapshot.sigma_velocity[:2].max(axis=0, initial=0.0) >= VAGUE)


def hangs_low(snapshot: Snapshot, settings: SurfaceSettings) -> Mask:
    """Return (n,) bool: objects known to be deeper than the clearance."""
    lower = snapshot.position[2] - settings.down_m - settings.clearance_m
    return np.asarray(lower > MARGIN_SIGMAS * snapshot.sigma_position[2])


def may_be_at_surface(snapshot: Snapshot, view: View, settings: SurfaceSettings) -> Mask:
    """Return (n,) bool: objects that, by their heights and their last echoes' directions, may be at the surface."""
    age = np.maximum(view.utc_ns - snapshot.last_seen_utc_ns, 0) / NS
    place = (snapshot.position - snapshot.velocity * age).T
    place[:, 2] = settings.down_m
    head = view.head.position_ned - np.outer(age, view.head.velocity_ned)
    forward, starboard, down = ((place - head) @ rotation_matrix(view.head.attitude)).T
    away = np.hypot(forward, starboard)
    distance, elevation = np.hypot(away, down), np.arctan2(-down, away)
    in_fan = (np.abs(elevation) < LOBES * view.half_vertical) & (distance > NEAREST_M) & (head[:, 2] > settings.down_m)
    return np.asarray(in_fan & ~hangs_low(snapshot, settings))


def distances(snapshot: Snapshot, velocity: Floats) -> Floats:
    """Return (n,) squared distances of the objects' velocities from one, (2,), in standard deviations."""
    variance = snapshot.sigma_velocity[:2] ** 2 + SPREAD**2
    return np.asarray(((snapshot.velocity[:2] - velocity[:2, None]) ** 2 / variance).sum(axis=0))


def _mean_velocity(snapshot: Snapshot) -> Floats:
    weight = 1.0 / (snapshot.sigma_velocity[:2] ** 2 + SPREAD**2)
    return np.asarray((weight * snapshot.velocity[:2]).sum(axis=1) / weight.sum(axis=1))


def _extent(snapshot: Snapshot) -> float:
    return float(np.hypot(*np.ptp(snapshot.position[:2], axis=1)))
