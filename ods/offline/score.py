"""Quality of obstacle lists against the truth, as in the bench and `ods track`. Pure."""

import math
from collections import defaultdict
from dataclasses import dataclass, field

import msgspec
import numpy as np

from ods.base.clock import NS
from ods.messages import Obstacle, Truth, TruthObject
from ods.offline.run_record import RunRecord

STANDS_FOR_M = 5.0
"""An obstacle farther from an object than this does not stand for it."""
IN_PLAY = ("active", "stand_by", "hibernated")


class ObjectScore(msgspec.Struct, frozen=True):
    """How one object fared."""

    name: str
    tracked_share: float
    """Share of the lists, after `settle_s` in the sector, that have a track on it."""
    position_rms_m: float
    radius_error: float
    """Mean of estimated / true radius - 1."""
    ids: list[int]
    """Identities it had, in order."""


def score_objects(record: RunRecord, settle_s: float) -> tuple[list[ObjectScore], set[int]]:
    """Match obstacles with objects in every list; return a score an object and the ids that matched none, ever."""
    logs: dict[str, _ObjectLog] = defaultdict(_ObjectLog)
    all_ids: set[int] = set()
    for _, item in record.lists:
        truth = record.truths.get(item.ping_number)
        obstacles = [obstacle for obstacle in item.obstacles if obstacle.state in IN_PLAY]
        all_ids |= {obstacle.id for obstacle in obstacles}
        if truth is None:
            continue
        matched = match(truth, obstacles)
        for target in truth.objects:
            logs[target.name].note(target, matched.get(target.name), truth.t_ns, settle_s)
    true_ids = {number for log in logs.values() for number in log.ids}
    return [log.score(name) for name, log in sorted(logs.items()) if log.expected], all_ids - true_ids


def position_rms_m(objects: list[ObjectScore]) -> float:
    """Return the rms over all objects, each weighted by its share of the lists."""
    squares = [(o.position_rms_m**2, o.tracked_share) for o in objects if math.isfinite(o.position_rms_m)]
    return math.sqrt(sum(s * w for s, w in squares) / sum(w for _, w in squares)) if squares else math.inf


def match(truth: Truth, obstacles: list[Obstacle]) -> dict[str, Obstacle]:
    """Return the obstacle that stands for each object, by name: least sum of horizontal distances in STANDS_FOR_M."""
    from scipy.optimize import linear_sum_assignment  # 20 MB: only where lists are judged

    if not obstacles or not truth.objects:
        return {}
    far = 1e6
    cost = np.array([[_distance(obstacle, target) for obstacle in obstacles] for target in truth.objects])
    cost[cost > STANDS_FOR_M] = far
    rows, columns = linear_sum_assignment(cost)
    return {truth.objects[i].name: obstacles[j] for i, j in zip(rows, columns, strict=True) if cost[i, j] < far}


def _distance(obstacle: Obstacle, target: TruthObject) -> float:
    """Horizontal: one plane does not resolve depth."""
    return math.dist(obstacle.position_ned[:2], target.position_ned[:2])


@dataclass
class _ObjectLog:
    """The lists' reports of one object."""

    first_sight_ns: int | None = None
    expected: int = 0
    errors: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)
    ids: list[int] = field(default_factory=list)

    def note(self, target: TruthObject, found: Obstacle | None, t_ns: int, settle_s: float) -> None:
        if found is not None and self.ids[-1:] != [found.id]:
            self.ids.append(found.id)
        if not target.in_sector:
            return
        self.first_sight_ns = t_ns if self.first_sight_ns is None else self.first_sight_ns
        if t_ns - self.first_sight_ns < settle_s * NS:
            return
        self.expected += 1
        if found is not None:
            self.errors.append(_distance(found, target))
            self.ratios.append(found.radius_m / target.radius_m)

    def score(self, name: str) -> ObjectScore:
        return ObjectScore(
            name=name,
            tracked_share=len(self.errors) / self.expected,
            position_rms_m=float(np.sqrt(np.mean(np.square(self.errors)))) if self.errors else math.inf,
            radius_error=float(np.mean(self.ratios) - 1.0) if self.ratios else math.inf,
            ids=self.ids,
        )
