"""Compares the lists of a kind of scene with the truth, and checks their validity and cautions. Pure."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ods.assess.sea.judge import NEAR_M, SceneScore, judge
from ods.assess.sea.kinds import Kind
from ods.assess.sea.run import Listed
from ods.assess.sea.scene_objects import SceneObjects
from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.messages import Obstacle, ObstacleList, Truth
from ods.tracker.existence import lifecycle
from ods.tracker.output.validity import SETTLE_S

STATES = {"active": lifecycle.ACTIVE, "stand_by": lifecycle.STAND_BY, "hibernated": lifecycle.HIBERNATED}

LATER_S = 1.5 * SETTLE_S
"""From then on what lists say of themselves counts: before it none is valid."""


class KindScore(NamedTuple):
    """How one kind went."""

    kind: Kind
    scene: SceneScore
    """Of the obstacles that are not marked as multipath."""
    marked: int
    """Ids that were marked as multipath."""
    valid: float
    """Share of the lists from `LATER_S` on."""
    said: list[tuple[str, float]]
    """What lists said of themselves from then on, and when first, s; said again with other figures it counts once."""
    error_m: float
    """Of active obstacles near bodies, root mean square, horizontal; NaN without any."""
    nees: float
    """Their squared error over the reported covariance, mean: 2 when errors are as large as reported."""


class TrackedList(NamedTuple):
    """One ping: the truth and its list."""

    truth: Truth
    list: ObstacleList
    detections: int
    chain_ms: float
    tracker_ms: float


def judged(kind: Kind, lists: Sequence[TrackedList], bodies: SceneObjects, seed: int) -> KindScore:
    """Return the score of the lists of a kind, one a ping; there are some."""
    score = judge(kind.name, [_listed(item) for item in lists], bodies, seed)
    marked = {each.id for item in lists for each in item.list.obstacles if each.multipath_of >= 0}
    settled = [item for item in lists if item.truth.t_ns - lists[0].truth.t_ns >= LATER_S * NS]
    said: dict[str, tuple[str, float]] = {}
    for item in settled:
        for text in (*item.list.reasons, item.list.unseen_why, item.list.caution):
            if text:
                said.setdefault(words_of(text), (text, item.truth.t_ns / NS))
    errors = np.array([each for item in settled for each in _errors(item, bodies)]).reshape(-1, 2)
    valid = float(np.mean([item.list.valid for item in settled])) if settled else math.nan
    error_m = float(np.sqrt(errors[:, 0].mean())) if len(errors) else math.nan
    nees = float(errors[:, 1].mean()) if len(errors) else math.nan
    return KindScore(kind, score, len(marked), valid, list(said.values()), error_m, nees)


def words_of(text: str) -> str:
    """Return a text without its figures."""
    return " ".join(word for word in text.split() if not any(letter.isdigit() for letter in word))


def _listed(item: TrackedList) -> Listed:
    """Return what judge() asks of a list, without what is marked as multipath or ended."""
    stands = [each for each in item.list.obstacles if each.state in STATES and each.multipath_of < 0]
    heard_from_db = math.nan if item.list.heard_from_db is None else item.list.heard_from_db
    return Listed(
        item.truth,
        item.detections,
        np.array([each.id for each in stands], np.int64),
        np.array([STATES[each.state] for each in stands], np.int64),
        _places(stands),
        np.array([each.radius_m for each in stands], np.float64),
        item.chain_ms,
        item.tracker_ms,
        item.list.valid,
        heard_from_db,
    )


def _places(obstacles: Sequence[Obstacle]) -> Floats:
    return np.array([each.position_ned[:2] for each in obstacles], np.float64).reshape(-1, 2)


def _errors(item: TrackedList, bodies: SceneObjects) -> Iterator[tuple[float, float]]:
    """Yield squared horizontal error, m2, and that over the reported covariance, of the active obstacle nearest to each
    body that has one near."""
    active = [each for each in item.list.obstacles if each.state == "active" and each.multipath_of < 0]
    if not active:
        return
    places = _places(active)
    wanted = [each for each in item.truth.objects if each.name in bodies.targets]
    for body in wanted:
        offset = places - body.position_ned[:2]
        nearest = int(np.hypot(*offset.T).argmin())
        north, east = offset[nearest].tolist()
        square = north * north + east * east
        if square < (NEAR_M + body.radius_m) ** 2:
            yield square, _normalised(north, east, active[nearest])


def _normalised(north: float, east: float, obstacle: Obstacle) -> float:
    nn, ee, ne = obstacle.sigma_position[0] ** 2, obstacle.sigma_position[1] ** 2, obstacle.covariance_ne
    return (ee * north**2 - 2.0 * ne * north * east + nn * east**2) / (nn * ee - ne**2)
