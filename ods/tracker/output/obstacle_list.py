"""The planner's obstacle list: the full picture each time, and what ended, said several times over."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.messages import ClosestApproach, Obstacle, Prediction, TrackState
from ods.tracker.output.closest_approach import Course, closest_approach
from ods.tracker.output.snapshot import Picture
from ods.tracker.settings import MotionSettings, PlannerSettings
from ods.tracker.track import lifecycle

NAMES: dict[int, TrackState] = {
    lifecycle.ACTIVE: "active",
    lifecycle.STAND_BY: "stand_by",
    lifecycle.HIBERNATED: "hibernated",
    lifecycle.TERMINATED: "terminated",
}


class ObstacleLister:
    """Turns pictures into obstacles, with the memory of what ended lately.

    `counters`: `obstacle_not_finite` (left out: no number that is not finite leaves the tracker).
    """

    def __init__(self, settings: PlannerSettings, motion: MotionSettings) -> None:
        self.counters: Counter[str] = Counter()
        self._settings = settings
        self._motion = motion
        self._ended: dict[int, tuple[Obstacle, int]] = {}

    def end(self, picture: Picture) -> None:
        """Announce the objects of `picture` as terminated in the next lists."""
        picture = self._fit(picture)
        alone: list[list[Prediction]] = [[]] * len(picture)
        for obstacle in _obstacles(picture, [None] * len(picture), alone):
            ended = msgspec.structs.replace(obstacle, state="terminated")
            self._ended[obstacle.id] = (ended, self._settings.announce_ended)

    def obstacles(self, picture: Picture, course: Course | None = None) -> list[Obstacle]:
        """Return the next list: all objects of `picture`, then those that ended.

        course: the vehicle's at the same time, if known.
        """
        picture = self._fit(picture)
        present = _obstacles(picture, self._approaches(picture, course), self._predictions(picture))
        for obstacle in present:
            self._ended.pop(obstacle.id, None)
        ended = [obstacle for obstacle, _ in self._ended.values()]
        self._ended = {i: (obstacle, left - 1) for i, (obstacle, left) in self._ended.items() if left > 1}
        return present + ended

    def _fit(self, picture: Picture) -> Picture:
        """Return the objects fit to be told, with the uncertainty of what a sonar cannot see of a shape."""
        numbers = (picture.position, picture.velocity, picture.sigma_position, picture.sigma_velocity)
        total = sum(a.sum(axis=0) for a in numbers) + picture.radius + picture.sigma_radius + picture.existence
        finite = np.isfinite(total + picture.covariance_ne)
        if not finite.all():
            self.counters["obstacle_not_finite"] += int(np.count_nonzero(~finite))
            picture = picture.take(finite)
        shape = self._settings.shape_sigma * picture.radius
        horizontal = np.hypot(picture.sigma_position[:2], shape)
        return replace(
            picture,
            sigma_position=np.vstack([horizontal, picture.sigma_position[2:]]),
            sigma_radius=np.hypot(picture.sigma_radius, shape),
        )

    def _approaches(self, picture: Picture, course: Course | None) -> Iterable[ClosestApproach | None]:
        if course is None:
            return [None] * len(picture)
        nearest = closest_approach(picture, course, self._motion, self._settings.approach_horizon_s)
        return map(ClosestApproach, *(a.tolist() for a in (nearest.time_s, nearest.distance_m, nearest.sigma_m)))

    def _predictions(self, picture: Picture) -> Iterable[list[Prediction]]:
        leads = self._settings.lead_times_s
        later = [picture.carried_on(lead, self._motion) for lead in leads]
        each = [
            [
                Prediction(lead, p, s)
                for p, s in zip(_vectors(then.position), _vectors(then.sigma_position), strict=True)
            ]
            for lead, then in zip(leads, later, strict=True)
        ]
        return map(list, zip(*each, strict=True)) if each else [[]] * len(picture)


def _obstacles(
    picture: Picture, approaches: Iterable[ClosestApproach | None], predictions: Iterable[list[Prediction]]
) -> list[Obstacle]:
    return list(
        map(
            Obstacle,
            picture.id.tolist(),
            [NAMES[state] for state in picture.state.tolist()],
            _vectors(picture.position),
            _vectors(picture.velocity),
            picture.radius.tolist(),
            _vectors(picture.sigma_position),
            _vectors(picture.sigma_velocity),
            picture.sigma_radius.tolist(),
            picture.first_seen_utc_ns.tolist(),
            picture.last_seen_utc_ns.tolist(),
            picture.times_seen.tolist(),
            np.clip(picture.existence, 0.0, 1.0).tolist(),
            picture.covariance_ne.tolist(),
            approaches,
            predictions,
        )
    )


def _vectors(columns: Floats) -> list[tuple[float, float, float]]:
    """Return the columns of a (3, n) array."""
    return list(zip(*columns.tolist(), strict=True))
