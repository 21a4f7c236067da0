"""An obstacle list extrapolated to the instant of sending, nearest obstacles first.

A list is some tenths of a second old when a bridge sends it; receivers without its age get present positions.
"""

import math
from dataclasses import dataclass

from ods.base.clock import NS
from ods.base.frames.quaternion import Vector3
from ods.messages import ClosestApproach, Obstacle, ObstacleList, PoseAt


@dataclass(frozen=True, slots=True)
class ExtrapolatedList:
    """A valid list, its vehicle pose, and the instant of sending, CLOCK_MONOTONIC."""

    obstacle_list: ObstacleList
    pose: PoseAt
    now_ns: int

    @property
    def age_s(self) -> float:
        """Time since the instant that the list is valid for."""
        return (self.now_ns - self.obstacle_list.t_ns) / NS

    @property
    def utc_ns(self) -> int:
        """UTC now, by the clock that the list's UTC is of."""
        return self.obstacle_list.utc_ns + self.now_ns - self.obstacle_list.t_ns

    def vehicle(self) -> Vector3:
        """Return where the vehicle is now, NED, m."""
        return _moved(self.pose.position_ned, self.pose.velocity_ned, self.age_s)

    def place(self, obstacle: Obstacle) -> Vector3:
        """Return where an obstacle's centre is now, NED, m, if it keeps its velocity."""
        return _moved(obstacle.position_ned, obstacle.velocity_ned, self.age_s)

    def edge_m(self, obstacle: Obstacle) -> float:
        """Return the horizontal distance now from the vehicle's origin to the obstacle's edge; below 0: inside."""
        north, east, _ = self.place(obstacle)
        own_north, own_east, _ = self.vehicle()
        return math.hypot(north - own_north, east - own_east) - obstacle.radius_m

    def approach_s(self, approach: ClosestApproach) -> float:
        """Return the time from now to the closest approach; 0: it is over."""
        return max(0.0, approach.time_s - self.age_s)

    def nearest(self, most: int, *, ignored: bool = True) -> list[Obstacle]:
        """Return the obstacles that have not ended, nearest edge first, `most` at most.

        ignored: those, too, that an operator said to ignore: for a receiver that is informed of it, or leans to the
        safe side.
        """
        present = [
            (self.edge_m(obstacle), obstacle) for obstacle in self.obstacle_list.obstacles if _is_there(obstacle)
        ]
        if not ignored:
            present = [each for each in present if each[1].ignored_by < 0]
        finite = [each for each in present if math.isfinite(each[0])]
        return [obstacle for _, obstacle in sorted(finite, key=lambda each: each[0])[:most]]

    def left_out(self, sent: int) -> int:
        """Return how many obstacles are known and not among the `sent` ones."""
        present = sum(map(_is_there, self.obstacle_list.obstacles))
        return self.obstacle_list.left_out + present - sent


def is_finite(pose: PoseAt) -> bool:
    """Return whether a pose is one: places are counted from it."""
    return math.isfinite(sum((*pose.position_ned, *pose.attitude, *pose.velocity_ned)))


def _is_there(obstacle: Obstacle) -> bool:
    return obstacle.state != "terminated"


def _moved(place: Vector3, velocity: Vector3, seconds: float) -> Vector3:
    return (
        place[0] + velocity[0] * seconds,
        place[1] + velocity[1] * seconds,
        place[2] + velocity[2] * seconds,
    )
