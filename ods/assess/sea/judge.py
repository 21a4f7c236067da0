"""Compares the lists of a scene with the truth. Pure."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ods.assess.sea.run import Listed
from ods.assess.sea.scene_objects import SceneObjects, group_of
from ods.base.arrays import Mask
from ods.base.clock import NS
from ods.messages import Truth
from ods.tracker.existence import lifecycle

LOUD_DB = 10.0
"""Level over its surroundings, dB, from which an object has to be tracked."""
SETTLE_S = 1.0
"""once it has been so for the first time this long ago."""
NEAR_M = 2.0
"""Largest distance, m, of a reported object from an obstacle's edge to stand for it. Reported circles that overlap an
obstacle are not false."""
IN_PLAY = (lifecycle.ACTIVE, lifecycle.STAND_BY, lifecycle.HIBERNATED)


@dataclass(frozen=True)
class TargetScore:
    """How one object, or one group of them, fared."""

    name: str
    expected: int
    """Number of lists that had to contain it."""
    tracked: int
    """Number of these lists that contained it."""
    confirmed_m: float
    """Horizontal distance from the vehicle when it was first listed as active, m; NaN: it never was."""
    confirmed_s: float
    """Time until then from its first `LOUD_DB`, s; below 0: it was found before."""
    margin_db: float
    """How far its echo is over the level from which echoes are detected, median of those lists, dB."""

    @property
    def share(self) -> float:
        """Share of the lists that have it; NaN when none had to."""
        return self.tracked / self.expected if self.expected else float("nan")


@dataclass(frozen=True)
class SceneScore:
    """How a scene went."""

    scene: str
    seed: int
    targets: tuple[TargetScore, ...]
    false_ids: int
    """Active obstacles that were, in most valid lists, near nothing."""
    false_at_a_time: float
    """Of those, in a list, mean."""
    minutes: float
    detections: float
    """A ping, mean."""
    chain_ms: float
    """Median, as"""
    tracker_ms: float

    @property
    def name(self) -> str:
        """How tables call it."""
        return f"{self.scene} {self.seed}" if self.seed else self.scene

    @property
    def false_a_minute(self) -> float:
        """False obstacles that came in a minute."""
        return self.false_ids / self.minutes

    @property
    def least_share(self) -> float:
        """Share of the object that was tracked least; NaN when nothing had to be."""
        shares = [target.share for target in self.targets if target.expected]
        return min(shares, default=float("nan"))


def judge(scene: str, lists: Sequence[Listed], bodies: SceneObjects, seed: int = 0) -> SceneScore:
    """Return the score of the lists of a scene's draw `seed`, one a ping; there are some."""
    logs = {name: _TargetLog(name) for name in bodies.targets}
    away: Counter[int] = Counter()
    active: Counter[int] = Counter()
    for item in lists:
        t_s = item.truth.t_ns / NS
        distance = bodies.distances(t_s, item.place)
        reach = np.maximum(NEAR_M, item.radius)[:, None]
        alone = ~(distance < reach).any(axis=1)
        is_active = item.state == lifecycle.ACTIVE
        if item.valid:
            active.update(item.id[is_active].tolist())
            away.update(item.id[is_active & alone].tolist())
        over = _over_surroundings(item.truth)
        for name, log in logs.items():
            members = np.array([group == name for group in bodies.groups])
            log.note(item, np.asarray((distance[:, members] < NEAR_M).any(axis=1)), t_s, over.get(name, 0.0))
    false = {number for number, count in away.items() if 2 * count > active[number]}
    return SceneScore(
        scene,
        seed,
        tuple(log.score() for log in logs.values()),
        len(false),
        sum(active[number] for number in false) / len(lists),
        max(lists[-1].truth.t_ns - lists[0].truth.t_ns, 1) / NS / 60.0,
        float(np.mean([item.detections for item in lists])),
        float(np.median([item.chain_ms for item in lists])),
        float(np.median([item.tracker_ms for item in lists])),
    )


def _over_surroundings(truth: Truth) -> dict[str, float]:
    """Return how far, dB, the loudest of each group is over its surroundings; outside of the sector both are 0."""
    over: dict[str, float] = {}
    for each in truth.objects:
        name = group_of(each.name)
        over[name] = max(over.get(name, -math.inf), each.peak_db - each.background_db)
    return over


class _TargetLog:
    """The lists' reports of one target."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._expected = self._tracked = 0
        self._loud_s = self._confirmed_s = self._confirmed_m = float("nan")
        self._margins_db: list[float] = []

    def note(self, item: Listed, near: Mask, t_s: float, over_db: float) -> None:
        """Take a list in.

        near: (n,) objects that stand for the target; over_db: how far it is over its surroundings.
        """
        if over_db >= LOUD_DB and np.isnan(self._loud_s):
            self._loud_s = t_s
        if over_db >= LOUD_DB and t_s - self._loud_s >= SETTLE_S:
            self._expected += 1
            self._margins_db.append(over_db - item.heard_from_db)
            self._tracked += bool((near & np.isin(item.state, IN_PLAY)).any())
        if np.isnan(self._confirmed_s) and (near & (item.state == lifecycle.ACTIVE)).any():
            self._confirmed_s, self._confirmed_m = t_s, _distance(self._name, item.truth)

    def score(self) -> TargetScore:
        """Return the figures."""
        late_s = self._confirmed_s - self._loud_s
        margin_db = float(np.median(self._margins_db)) if self._margins_db else math.nan
        return TargetScore(self._name, self._expected, self._tracked, self._confirmed_m, late_s, margin_db)


def _distance(name: str, truth: Truth) -> float:
    """Return the horizontal distance from the vehicle to the nearest of a group."""
    places = np.array([each.position_ned[:2] for each in truth.objects if group_of(each.name) == name])
    return float(np.hypot(*(places - truth.position_ned[:2]).T).min())
