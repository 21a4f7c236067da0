"""The planner's obstacle list: the full picture each time, and what ended, said several times over."""

from collections import Counter

import msgspec
import numpy as np

from ods.messages import Obstacle, TrackState
from ods.tracker import life
from ods.tracker.picture import Picture

NAMES: dict[int, TrackState] = {
    life.ACTIVE: "active",
    life.STAND_BY: "stand_by",
    life.HIBERNATED: "hibernated",
    life.TERMINATED: "terminated",
}


class ObstacleLister:
    """Turns pictures into obstacles, with the memory of what ended lately.

    `counters`: `obstacle_not_finite` (left out: no number that is not finite leaves the tracker).
    """

    def __init__(self, announce_ended: int, shape_sigma: float) -> None:
        """`announce_ended`, `shape_sigma`: see `PlannerSettings`."""
        self.counters: Counter[str] = Counter()
        self._shape_sigma = shape_sigma
        self._announce = announce_ended
        self._ended: dict[int, tuple[Obstacle, int]] = {}

    def end(self, picture: Picture) -> None:
        """Announce the objects of `picture` as terminated in the next lists."""
        for obstacle in self._obstacles(picture):
            self._ended[obstacle.id] = (msgspec.structs.replace(obstacle, state="terminated"), self._announce)

    def obstacles(self, picture: Picture) -> list[Obstacle]:
        """Return the next list: all objects of `picture`, then those that ended."""
        present = self._obstacles(picture)
        for obstacle in present:
            self._ended.pop(obstacle.id, None)
        ended = [obstacle for obstacle, _ in self._ended.values()]
        self._ended = {i: (obstacle, left - 1) for i, (obstacle, left) in self._ended.items() if left > 1}
        return present + ended

    def _obstacles(self, picture: Picture) -> list[Obstacle]:
        numbers = (picture.position, picture.velocity, picture.sigma_position, picture.sigma_velocity)
        total = sum(a.sum(axis=0) for a in numbers) + picture.radius + picture.sigma_radius + picture.existence
        finite = np.isfinite(total)
        if not finite.all():
            self.counters["obstacle_not_finite"] += int(np.count_nonzero(~finite))
            picture = picture.take(finite)
        shape = self._shape_sigma * picture.radius
        horizontal = np.hypot(picture.sigma_position[:2], shape)
        columns = (
            picture.id,
            picture.state,
            picture.position.T,
            picture.velocity.T,
            picture.radius,
            np.vstack([horizontal, picture.sigma_position[2:]]).T,
            picture.sigma_velocity.T,
            np.hypot(picture.sigma_radius, shape),
            picture.first_seen_utc_ns,
            picture.last_seen_utc_ns,
            picture.times_seen,
            np.clip(picture.existence, 0.0, 1.0),
        )
        return [
            Obstacle(i, NAMES[state], tuple(p), tuple(v), radius, tuple(sp), tuple(sv), sr, first, last, seen, e)
            for i, state, p, v, radius, sp, sv, sr, first, last, seen, e in zip(
                *(column.tolist() for column in columns), strict=True
            )
        ]
