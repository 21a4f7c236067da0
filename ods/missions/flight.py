"""One mission: the vehicle in the loop, from the start to the goal, a collision or the end of patience."""

import math
from collections.abc import Iterator
from statistics import fmean

import msgspec
import numpy as np

from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.messages import ObstacleList, Vector3
from ods.missions.all_knowing.path_follower import PathFollower, fastest_path_follower
from ods.missions.detections.laws import Laws
from ods.missions.failing.witness import Warned, Witness
from ods.missions.outcome import Ending, Outcome
from ods.missions.settings import Arm, Campaign
from ods.missions.watch import STEPS, Received, TruthWatch, watch_of
from ods.missions.world import World, make_world
from ods.offline.mission import MissionSettings
from ods.planner.conflict import conflict
from ods.planner.planner import Planner, SetPoint
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.steered import SteeredVehicle, VehicleState, at_start

NEARLY = 2.0
"""Multiple of the distance to keep within which an obstacle is a true reason for an evasion: positions are not
exact."""

LISTED_M = 1.0
"""Distance beyond an obstacle's radius within which a listed position stands for it, m."""


class Referee:
    """Sees the truth: how near the vehicle came, and whether evasions had a reason."""

    def __init__(self, world: World, radius_m: float) -> None:
        self._world, self._radius_m = world, radius_m
        self.clearance_m = math.inf
        self.path_m = self.not_valid_s = 0.0
        self.evasions = self.groundless = 0
        self._evading = self._grounded = False
        self.witness = Witness(world)
        self._nearest: tuple[float, int] | None = None
        """When it came nearest, s, and to which obstacle."""
        self.first_listed_m: dict[int, float] = {}
        """By the obstacles' numbers: how far the edge was when it was listed first, m."""
        self.time_to_collision_s = math.inf

    def see(self, was: VehicleState, now: VehicleState) -> None:
        """Take a step of the vehicle."""
        self.path_m += math.hypot(now.north_m - was.north_m, now.east_m - was.east_m, now.down_m - was.down_m)
        clear = self._world.clearances(now.t_s, now.north_m, now.east_m, now.down_m)
        nearest_m = float(clear.min(initial=math.inf)) - self._radius_m
        if nearest_m < self.clearance_m:
            self.clearance_m, self._nearest = nearest_m, (now.t_s, int(clear.argmin()))
        if self.clearance_m < 0.0 and int(clear.argmin()) not in self.first_listed_m:
            self.time_to_collision_s = 0.0

    def receive(self, received: ObstacleList, now: VehicleState) -> None:
        """Take a list: which obstacles are in it for the first time, seen from where the vehicle is now."""
        if not received.obstacles or len(self.first_listed_m) == len(self._world.radius_m):
            return
        listed = np.array([each.position_ned[:2] for each in received.obstacles])
        places, radius = self._world.places(received.t_ns / NS), self._world.radius_m
        off = np.hypot(*(places[:, None] - listed).transpose(2, 0, 1))
        clear = self._world.clearances(now.t_s, now.north_m, now.east_m, now.down_m)
        new = set(np.flatnonzero((off < radius[:, None] + LISTED_M).any(axis=1)).tolist()) - self.first_listed_m.keys()
        if new:
            until_s = self._world.until_contact_s(now, self._radius_m)
            self.time_to_collision_s = min(self.time_to_collision_s, *until_s[list(new)].tolist())
            self.first_listed_m.update((which, float(clear[which])) for which in sorted(new))

    def said(self) -> tuple[bool, Warned]:
        """Return the reports of the obstacle nearest to the vehicle, see `Witness.before`."""
        return (False, "") if self._nearest is None else self.witness.before(*self._nearest)

    def judge(self, set_point: SetPoint, grounded: bool, dt_s: float) -> None:
        """Record the planner's action; `grounded`: an obstacle is a true reason to leave the course."""
        self.not_valid_s += 0.0 if set_point.valid else dt_s
        if set_point.avoiding and not self._evading:
            self.evasions += 1
            self._grounded = False
        if set_point.avoiding:
            self._grounded = self._grounded or grounded
        elif self._evading:
            self.end()
        self._evading = set_point.avoiding

    def end(self) -> None:
        """The evasion, or the mission, is over."""
        self.groundless += self._evading and not self._grounded
        self._evading = False


class Flight:
    """One arm's mission in one world."""

    def __init__(
        self,
        campaign: Campaign,
        number: int,
        arm: Arm,
        sonar: SonarModel,
        onboard: MissionSettings,
        world: World | None = None,
        laws: Laws | None = None,
    ) -> None:
        """`world`: none: that of the campaign and number; `laws`: see `OnBoard`.

        Raises OdsError where sonar and world do not fit.
        """
        self.world = make_world(campaign.world, campaign.seed, number) if world is None else world
        self._number, self._arm, self._campaign = number, arm, campaign
        self._period_s = sonar.ping_period_s
        goal = (campaign.world.length_m, 0.0, campaign.world.down_m)
        start = at_start(0.0, campaign.planner.slow_m_s, (0.0, 0.0, goal[2]))
        self.vehicle = SteeredVehicle(campaign.vehicle, start, self.world.current_m_s)
        self.planner = self._planner(start, goal)
        self.referee = Referee(self.world, campaign.vehicle.radius_m)
        self._wide = msgspec.structs.replace(campaign.planner, keep_m=NEARLY * campaign.planner.keep_m)
        self._true = TruthWatch(self.world, sonar.range_max_m)
        try:
            self.watch = watch_of(arm, self.world, self.vehicle, sonar, onboard, laws, campaign.errors)
        except ValueError as error:
            raise OdsError(f"world: {error}") from error
        self.received: Received | None = None
        self._ending: Ending = "time-out"

    def _planner(self, start: VehicleState, goal: Vector3) -> Planner | PathFollower:
        if self._arm != "all_knowing":
            return Planner(self._campaign.planner, [goal])
        led = fastest_path_follower(self.world, self._campaign, start, self._period_s / STEPS, STEPS)
        first = led.steer(0)
        self.vehicle.obey(first.heading_rad, first.speed_m_s, first.down_m)
        return led

    def fly(self) -> Outcome:
        """Return what came of it. Raises OdsError."""
        for _ in self.pings():
            pass
        return self.outcome()

    def pings(self) -> Iterator[VehicleState]:
        """Go on ping by ping to the end; yield where each was sent from. Raises OdsError."""
        for ping in range(self.most_pings):
            sent = self.vehicle.way[-1]
            arrived = self.step(ping)
            yield sent
            if self.referee.clearance_m < 0.0:
                self._ending = "collision"
                break
            if arrived:
                self._ending = "success"
                break
        self.referee.end()

    @property
    def most_pings(self) -> int:
        """Number of pings after which the mission is given up."""
        campaign = self._campaign
        patience_s = campaign.longest * campaign.world.length_m / campaign.planner.cruise_m_s
        return math.ceil(patience_s / self._period_s)

    def step(self, ping: int) -> bool:
        """Go on by one ping; return whether the goal is reached.

        While its echoes come the vehicle goes by what the planner made of those before.
        """
        sent = self.vehicle.way[-1]
        for _ in range(STEPS):
            was = self.vehicle.way[-1]
            self.referee.see(was, self.vehicle.step(self._period_s / STEPS))
        self.received = self.watch.look(ping, sent)
        if self.received is not None:
            self.planner.receive(*self.received)
            self.referee.receive(self.received.list, self.vehicle.way[-1])
            self.referee.witness.receive(*self.received, sent, self.vehicle.way[-1].t_s)
        now_ns = round(self.vehicle.way[-1].t_s * NS)
        set_point = self.planner.steer(now_ns)
        self.vehicle.obey(set_point.heading_rad, set_point.speed_m_s, set_point.down_m)
        self.referee.judge(set_point, self._in_the_way(set_point, ping, sent, now_ns), self._period_s)
        return set_point.arrived

    def _in_the_way(self, set_point: SetPoint, ping: int, sent: VehicleState, now_ns: int) -> bool:
        if not set_point.avoiding or self._arm == "truth":
            return set_point.avoiding
        assert isinstance(self.planner, Planner)
        true = self._true.look(ping, sent).list.obstacles
        return bool(conflict(self.planner.direct(now_ns), true, now_ns / NS - sent.t_s, self._wide)[0] > 0.0)

    def outcome(self) -> Outcome:
        """Return what came of it, once it is over."""
        seen, campaign = self.referee, self._campaign
        listens, warned_s = self._arm in ("ods", "truth"), seen.time_to_collision_s
        clearance = round(seen.clearance_m, 3) if math.isfinite(seen.clearance_m) else None
        listed, warning = seen.said()
        return Outcome(
            mission=self._number,
            arm=self._arm,
            ending=self._ending,
            near_miss=0.0 <= seen.clearance_m < campaign.near_miss_m,
            clearance_m=clearance,
            path_m=round(seen.path_m, 3),
            time_s=round(self.vehicle.way[-1].t_s, 3),
            evasions=seen.evasions,
            evasions_of_nothing=seen.groundless,
            listed=len(seen.first_listed_m),
            first_listed_m=round(fmean(seen.first_listed_m.values()), 3) if seen.first_listed_m else None,
            time_to_collision_s=round(warned_s, 3) if listens and math.isfinite(warned_s) else None,
            not_valid_s=round(seen.not_valid_s, 3),
            nearest_listed=listed,
            warning=warning,
        )
