"""In place of a planner: follows the fastest path, which was found before the start."""

from ods.messages import Clearance, ObstacleList
from ods.missions.all_knowing.search import PathQuery, TimedPath, fastest_path
from ods.missions.settings import Campaign
from ods.missions.world import World
from ods.planner.planner import SetPoint
from ods.sim_sonar.steered import VehicleState


class PathFollower:
    """Returns the set points of a path one by one; without a path it goes straight on."""

    def __init__(self, way: TimedPath | None, start: VehicleState, cruise_m_s: float, steps: int) -> None:
        """`steps`: simulation steps between two set points."""
        self._way, self._start, self._cruise_m_s, self._steps = way, start, cruise_m_s, steps
        self._asked = 0

    def receive(self, received: ObstacleList, clearance: Clearance | None) -> None:
        """Ignore the list: the path is fixed."""

    def steer(self, now_ns: int) -> SetPoint:
        """Return the next set point; the first call is before the start."""
        gone = self._asked * self._steps
        self._asked += 1
        if self._way is None:
            return SetPoint(self._start.heading_rad, self._cruise_m_s, self._start.down_m)
        heading, speed = self._way.orders[min(gone // self._way.steps, len(self._way.orders) - 1)]
        return SetPoint(heading, speed, self._start.down_m, arrived=gone >= len(self._way.places) - 1)


def fastest_path_follower(
    world: World, campaign: Campaign, start: VehicleState, dt_s: float, steps: int
) -> PathFollower:
    """Return the fastest path of a mission: without near misses if possible, otherwise without collisions."""
    planner, vehicle = campaign.planner, campaign.vehicle
    for keep_m in (campaign.near_miss_m, 0.0):
        query = PathQuery(
            start, (campaign.world.length_m, 0.0), planner.reached_m, world.places, world.radius_m,
            keep_m + vehicle.radius_m, vehicle, (planner.cruise_m_s, planner.slow_m_s), world.current_m_s, dt_s, steps,
            campaign.longest * campaign.world.length_m / planner.cruise_m_s,
        )  # fmt: skip
        way = fastest_path(query)
        if way is not None:
            return PathFollower(way, start, planner.cruise_m_s, steps)
    return PathFollower(None, start, planner.cruise_m_s, steps)
