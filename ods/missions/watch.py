"""Where the planner's lists come from, arm by arm."""

from collections.abc import Iterator
from itertools import count
from typing import NamedTuple, Protocol

import numpy as np

from ods.base.clock import NS
from ods.base.quaternion import conjugate, rotated
from ods.messages import Clearance, Obstacle, ObstacleList, Ping, Pose, PoseAt
from ods.missions.settings import Arm
from ods.missions.world import World
from ods.offline.mission import Detecting, MissionSettings, Tracking
from ods.offline.poses import SIGMA_ATTITUDE_RAD, SIGMA_POSITION_M
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.ins.place import over_bottom
from ods.sim_sonar.ins.sigmas import USUAL_SIGMAS
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.shots import START_UTC_NS
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.steered import Steered, VehicleState
from ods.tracker.clearance.clearance import ClearanceKeeper

SECTORS = 72
STILL = (0.0, 0.0, 0.0)
STEPS = 4
"""Of the vehicle, from ping to ping."""
POSE_STEPS = 2
"""Steps of the vehicle from pose to pose."""


class Heard(NamedTuple):
    """What the planner is told after a ping."""

    list: ObstacleList
    clearance: Clearance | None


class Watch(Protocol):
    """Looks at the world from the vehicle."""

    def look(self, number: int, sent: VehicleState) -> Heard | None:
        """Return what ping `number`, sent from there, led to, once the vehicle has gone on to the next; None: nothing.

        Raises OdsError.
        """


class Told:
    """Tells what is really there, as far as the sonar reaches, all around; with `blind` nothing at all."""

    def __init__(self, world: World, range_m: float, *, blind: bool = False) -> None:
        self._world, self._range_m, self._blind = world, range_m, blind

    def look(self, number: int, sent: VehicleState) -> Heard:
        """Return what is there at that time."""
        t_s, t_ns, pose = sent.t_s, round(sent.t_s * NS), pose_of(sent)
        near = []
        if not self._blind:
            away = self._world.clearances(t_s, *pose.position_ned)
            near = np.flatnonzero(away < self._range_m).tolist()
        places, down = self._world.places(t_s), self._world.settings.down_m
        obstacles = [self._obstacle(which, (*places[which].tolist(), down)) for which in near]
        told = ObstacleList(number, number, t_ns, t_ns, t_ns, True, [], obstacles, made_ns=t_ns, pose=pose)
        reach = [self._range_m] * SECTORS
        return Heard(
            told, Clearance(number, number, t_ns, t_ns, True, [0.0] * SECTORS, reach, [None] * SECTORS, pose=pose)
        )

    def _obstacle(self, which: int, place: tuple[float, float, float]) -> Obstacle:
        north, east = self._world.velocity[which].tolist()
        radius = float(self._world.radius_m[which])
        return Obstacle(which, "active", place, (north, east, 0.0), radius, STILL, STILL, 0.0, 0, 0, 1, 1.0)


class OnBoard:
    """Pipeline and tracker, as on board, on simulated images."""

    def __init__(self, world: World, vehicle: Steered, sonar: SonarModel, settings: MissionSettings) -> None:
        """Raises ValueError where sonar and world do not fit, PluginError, StageError."""
        self._vehicle = vehicle
        self._scene = Scene(world.scene(1.0), vehicle=vehicle)
        self._images = ImageSimulator(sonar, self._scene)
        self._noise = np.random.default_rng(np.random.SeedSequence(world.seed, spawn_key=(1,)))
        self._next: tuple[int, VehicleState] = (0, vehicle.way[0])
        self._tracking = Tracking(settings)
        self._keeper = ClearanceKeeper(settings.tracker.clearance)
        self._found = Detecting(settings).found(self._pings(), self._poses())

    def look(self, number: int, sent: VehicleState) -> Heard | None:
        """Return the list of a ping."""
        self._next = number, sent
        _, found = next(self._found)
        told = self._tracking.told(found)
        return None if told is None else Heard(told, self._keeper.after(told, found.detections))

    def _pings(self) -> Iterator[Ping]:
        while True:
            number, sent = self._next
            t_ns = round(sent.t_s * NS)
            yield self._images.ping(sent.t_s, number, t_ns, START_UTC_NS + t_ns)

    def _poses(self) -> Iterator[Pose]:
        """Yield the vehicle's poses, for ever: it has always gone on beyond the last echo."""
        for number in count():
            state = self._vehicle.way[POSE_STEPS * number]
            t_ns = round(state.t_s * NS)
            over = over_bottom(self._scene, np.array(state.place))
            if over is not None:
                over = max(0.0, over + USUAL_SIGMAS.over_bottom * self._noise.standard_normal())
            yield Pose(
                number,
                t_ns,
                START_UTC_NS + t_ns,
                state.place,
                state.attitude,
                rotated(conjugate(state.attitude), state.velocity_ned),
                SIGMA_POSITION_M,
                SIGMA_ATTITUDE_RAD,
                altitude_m=over,
                sigma_altitude_m=USUAL_SIGMAS.over_bottom,
            )


def watch_of(arm: Arm, world: World, vehicle: Steered, sonar: SonarModel, settings: MissionSettings) -> Watch:
    """Return how an arm looks at the world. Raises ValueError, PluginError, StageError."""
    if arm == "ods":
        return OnBoard(world, vehicle, sonar, settings)
    return Told(world, sonar.range_max_m, blind=arm == "none")


def pose_of(state: VehicleState) -> PoseAt:
    """Return the vehicle's true pose."""
    return PoseAt(state.place, state.attitude, state.velocity_ned, STILL, STILL)
