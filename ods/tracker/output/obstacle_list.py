"""The planner's obstacle list: all obstacles each time; terminated ones are repeated in several lists."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.messages import ClosestApproach, Obstacle, Prediction, TrackState
from ods.tracker.existence import lifecycle
from ods.tracker.output.bottom import Bottom, heights_above_bottom
from ods.tracker.output.closest_approach import Course, closest_approach
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.restart.state import Announced
from ods.tracker.settings import BottomSettings, MotionSettings, PlannerSettings

NAMES: dict[int, TrackState] = {
    lifecycle.ACTIVE: "active",
    lifecycle.STAND_BY: "stand_by",
    lifecycle.HIBERNATED: "hibernated",
    lifecycle.TERMINATED: "terminated",
}

_Stands = tuple[Sequence[float], Sequence[float | None], Sequence[float | None]]
"""Probability to be of the bottom, height over it and its standard deviation."""


class ObstacleLister:
    """Turns snapshots into obstacles, with the memory of what ended lately.

    `counters`: `obstacle_not_finite` (left out: no number that is not finite leaves the tracker).
    """

    def __init__(self, settings: PlannerSettings, motion: MotionSettings, bottom: BottomSettings) -> None:
        self.counters: Counter[str] = Counter()
        self._settings = settings
        self._motion = motion
        self._bottom = bottom
        self._ended: dict[int, tuple[Obstacle, int]] = {}

    def end(self, snapshot: Snapshot) -> None:
        """Announce the objects of `snapshot` as terminated in the next lists."""
        snapshot = self._fit(snapshot)
        alone: list[list[Prediction]] = [[]] * len(snapshot)
        for obstacle in _obstacles(snapshot, [None] * len(snapshot), alone, self._stands(snapshot, None)):
            ended = msgspec.structs.replace(obstacle, state="terminated")
            self._ended[obstacle.id] = (ended, self._settings.announce_ended)

    def state(self) -> list[Announced]:
        """Return what ended lately."""
        return [Announced(obstacle, left) for obstacle, left in self._ended.values()]

    def restore(self, state: list[Announced]) -> None:
        """Continue the announcements of another one."""
        self._ended = {each.obstacle.id: (each.obstacle, each.left) for each in state}

    def obstacles(
        self, snapshot: Snapshot, course: Course | None = None, bottom: Bottom | None = None
    ) -> list[Obstacle]:
        """Return the next list: all objects of `snapshot`, then those that ended.

        course: the vehicle's at the same time, if known; bottom: below it, likewise.
        """
        snapshot = self._fit(snapshot)
        approaches, predictions = self._approaches(snapshot, course), self._predictions(snapshot)
        present = _obstacles(snapshot, approaches, predictions, self._stands(snapshot, bottom))
        for obstacle in present:
            self._ended.pop(obstacle.id, None)
        ended = [obstacle for obstacle, _ in self._ended.values()][-self._settings.most_listed :]
        self._ended = {i: (obstacle, left - 1) for i, (obstacle, left) in self._ended.items() if left > 1}
        return present + ended

    def _fit(self, snapshot: Snapshot) -> Snapshot:
        """Return the objects fit to be reported, with the uncertainty of what a sonar cannot see of a shape."""
        numbers = (snapshot.position, snapshot.velocity, snapshot.sigma_position, snapshot.sigma_velocity)
        total = sum(a.sum(axis=0) for a in numbers) + snapshot.radius + snapshot.sigma_radius + snapshot.existence
        finite = np.isfinite(total + snapshot.covariance_ne)
        if not finite.all():
            self.counters["obstacle_not_finite"] += int(np.count_nonzero(~finite))
            snapshot = snapshot.take(finite)
        shape = self._settings.shape_sigma * snapshot.radius
        horizontal = np.hypot(snapshot.sigma_position[:2], shape)
        return replace(
            snapshot,
            sigma_position=np.vstack([horizontal, snapshot.sigma_position[2:]]),
            sigma_radius=np.hypot(snapshot.sigma_radius, shape),
        )

    def _approaches(self, snapshot: Snapshot, course: Course | None) -> Iterable[ClosestApproach | None]:
        if course is None:
            return [None] * len(snapshot)
        nearest = closest_approach(snapshot, course, self._motion, self._settings.approach_horizon_s)
        return map(ClosestApproach, *(a.tolist() for a in (nearest.time_s, nearest.distance_m, nearest.sigma_m)))

    def _stands(self, snapshot: Snapshot, bottom: Bottom | None) -> _Stands:
        if bottom is None:
            unknown: list[None] = [None] * len(snapshot)
            return [0.0] * len(snapshot), unknown, unknown
        stand = heights_above_bottom(snapshot, bottom, self._bottom)
        return stand.bottom.tolist(), stand.height_m.tolist(), stand.sigma_m.tolist()

    def _predictions(self, snapshot: Snapshot) -> Iterable[list[Prediction]]:
        leads = self._settings.lead_times_s
        after_s = np.repeat(np.array(leads, np.float64)[:, None], len(snapshot), axis=1)
        places, sigmas = snapshot.places_after(after_s, self._motion)
        each = [
            [Prediction(lead, p, s) for p, s in zip(_vectors(place), _vectors(sigma), strict=True)]
            for lead, place, sigma in zip(leads, places, sigmas, strict=True)
        ]
        return map(list, zip(*each, strict=True)) if each else [[]] * len(snapshot)


def _obstacles(
    snapshot: Snapshot,
    approaches: Iterable[ClosestApproach | None],
    predictions: Iterable[list[Prediction]],
    stands: _Stands,
) -> list[Obstacle]:
    return list(
        map(
            Obstacle,
            snapshot.id.tolist(),
            [NAMES[state] for state in snapshot.state.tolist()],
            _vectors(snapshot.position),
            _vectors(snapshot.velocity),
            snapshot.radius.tolist(),
            _vectors(snapshot.sigma_position),
            _vectors(snapshot.sigma_velocity),
            snapshot.sigma_radius.tolist(),
            snapshot.first_seen_utc_ns.tolist(),
            snapshot.last_seen_utc_ns.tolist(),
            snapshot.times_seen.tolist(),
            np.clip(snapshot.existence, 0.0, 1.0).tolist(),
            snapshot.covariance_ne.tolist(),
            approaches,
            predictions,
            snapshot.unseen_s.tolist(),
            *stands,
            np.clip(1.0 - snapshot.static, 0.0, 1.0).tolist(),
        )
    )


def _vectors(columns: Floats) -> list[tuple[float, float, float]]:
    """Return the columns of a (3, n) array."""
    return list(zip(*columns.tolist(), strict=True))
