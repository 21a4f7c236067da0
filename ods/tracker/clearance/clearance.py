"""The message to the planner: water known to be empty, remembered over pings."""

import math
from collections.abc import Sequence

import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.geometry import rotation_matrix
from ods.compiled import native
from ods.messages import Clearance, Detections, Obstacle, ObstacleList, PoseAt
from ods.tracker.clearance.fan_mask import Extent, extents_of, fan_mask
from ods.tracker.clearance.free_grid import FreeGrid, Head
from ods.tracker.clearance.sectors import OccupiedSectors, clear_water, nearest_edge
from ods.tracker.measurement.coverage.looked import observed_ranges_of
from ods.tracker.settings import MARGIN_SIGMAS, ClearanceSettings

FAR_TURN_S = 5.0
"""Longest time between two pings from which the turn rate is computed, s; beyond it the turn rate is unknown."""


class ClearanceKeeper:
    """Continues from list to list. A list that is not valid resets it: then no water is known to be empty."""

    def __init__(self, settings: ClearanceSettings) -> None:
        self._settings = settings
        self._grid: FreeGrid | None = None
        self._before: tuple[int, float] | None = None
        """When the head looked where: t_ns and azimuth."""

    def after(self, obstacles: ObstacleList, shown: Detections | None) -> Clearance:
        """Return the clearance of a list; `shown`: the detections of its ping, if there is one."""
        echoes = [] if shown is None else extents_of(shown.detections)
        if obstacles.valid and obstacles.pose is not None and obstacles.head is not None and shown is not None:
            self._look(obstacles.pose, obstacles.head, shown, echoes)
        else:
            self._grid = self._before = None
        return self._message(obstacles, echoes)

    def _look(self, pose: PoseAt, pose_of_head: PoseAt, shown: Detections, echoes: list[Extent]) -> None:
        sector = shown.sector
        if not sector.range_max_m > 0.0:
            self._grid = None
            return
        if self._grid is None or not self._grid.fits(sector.range_max_m):
            self._grid = FreeGrid(sector.range_max_m, self._settings)
        self._grid.move(np.array(pose.position_ned))
        head = Head(np.array(pose_of_head.position_ned), rotation_matrix(np.array(pose_of_head.attitude)))
        turn = self._turn_until_received(head, shown)
        if not shown.usable:
            return
        looked = observed_ranges_of(shown)
        if looked is not None:
            self._grid.look_through(shown.t_ns / NS, sector, looked, head, turn)
            return
        mask = fan_mask(sector, shown.processed_ranges_m, shown.unseen, echoes, turn)
        if mask is not None:
            self._grid.look(shown.t_ns / NS, mask, head, swept=shown.turn_s > 0.0)

    def _turn_until_received(self, head: Head, shown: Detections) -> float:
        """Return by how much the head turns until the farthest echo is back, rad; infinite if that is not known."""
        azimuth = math.atan2(head.turned[1, 0], head.turned[0, 0])
        before, self._before = self._before, (shown.t_ns, azimuth)
        if before is None or not shown.sound_speed > 0.0:
            return math.inf
        since_s = (shown.t_ns - before[0]) / NS
        if not 0.0 < since_s <= FAR_TURN_S:
            return math.inf
        turned = abs(math.remainder(azimuth - before[1], 2.0 * math.pi))
        return turned / since_s * 2.0 * shown.sector.range_max_m / shown.sound_speed

    def _message(self, obstacles: ObstacleList, echoes: list[Extent]) -> Clearance:
        n = self._settings.sectors
        bodies = _bodies(obstacles, echoes)
        to_m, from_m = np.zeros(n), np.zeros(n)
        if self._grid is not None:
            from_m, to_m = clear_water(self._grid.free(obstacles.t_ns / NS), self._grid.cell_m, n)
            to_m = np.minimum(to_m, nearest_edge(bodies, n, MARGIN_SIGMAS))
            if obstacles.left_out:
                to_m = np.minimum(to_m, max(bodies.distance_m, default=0.0))
            nothing = to_m <= from_m
            from_m[nothing] = to_m[nothing] = 0.0
        nearest = nearest_edge(bodies, n).tolist()
        return Clearance(
            seq=obstacles.seq,
            ping_number=obstacles.ping_number,
            t_ns=obstacles.t_ns,
            utc_ns=obstacles.utc_ns,
            valid=obstacles.valid,
            clear_from_m=from_m.tolist(),
            clear_to_m=to_m.tolist(),
            nearest_m=[distance if math.isfinite(distance) else None for distance in nearest],
            pose=obstacles.pose,
            site=obstacles.site,
            half_height_m=self._settings.half_height_m,
            fastest_m_s=self._settings.fastest_m_s,
            made_ns=obstacles.made_ns,
            made_utc_ns=obstacles.made_utc_ns,
        )


def _bodies(obstacles: ObstacleList, echoes: list[Extent]) -> OccupiedSectors:
    """Return the obstacles of a list and the echoes of its ping, as seen from the vehicle; none without its pose."""
    if obstacles.pose is None:
        return OccupiedSectors(*np.zeros((4, 0)))
    place = obstacles.pose.position_ned
    found = np.array([_of_obstacle(each, place) for each in obstacles.obstacles if each.state != "terminated"])
    bodies = found.reshape(-1, 4).T
    if obstacles.head is not None:
        bodies = np.hstack([bodies, _of_echoes(echoes, obstacles.head, place)])
    return OccupiedSectors(*np.ascontiguousarray(bodies))


_Body = tuple[float, float, float, float]
"""Azimuth, half width, distance, standard deviation."""


def _of_obstacle(obstacle: Obstacle, place: Sequence[float]) -> _Body:
    north, east = (obstacle.position_ned[axis] - place[axis] for axis in (0, 1))
    sigma = math.hypot(max(obstacle.sigma_position[:2]), obstacle.sigma_radius)
    away, wide = math.hypot(north, east), obstacle.radius_m + MARGIN_SIGMAS * sigma
    half = math.pi if away <= wide else math.asin(wide / away)
    return math.atan2(east, north), half, max(away - obstacle.radius_m, 0.0), sigma


def _of_echoes(echoes: list[Extent], head: PoseAt, place: Sequence[float]) -> Floats:
    """Return (4, m) echoes as seen from the vehicle: each by its near edge, in the middle and at both sides."""
    around = np.zeros((4, len(echoes)))
    from_vehicle = np.array(head.position_ned) - np.array(place)
    extents, turned = np.array(echoes, np.float64).reshape(-1, 5), rotation_matrix(np.array(head.attitude))
    native.echoes_around(extents, from_vehicle, turned, *around[:3])
    return around
