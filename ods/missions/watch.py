"""Sources of the planner's lists, arm by arm."""

import math
import time
from collections.abc import Iterator
from itertools import count
from typing import NamedTuple, Protocol

import numpy as np

from ods.base.clock import NS
from ods.base.frames.quaternion import conjugate, rotated
from ods.messages import Clearance, Obstacle, ObstacleList, Ping, Pose, PoseAt
from ods.missions.detections.draw import Drawing, Placed
from ods.missions.detections.laws import Laws
from ods.missions.detections.sights import fan_of, sights_of
from ods.missions.failing.errors import ErrorSettings
from ods.missions.failing.faint import scene_of
from ods.missions.settings import Arm
from ods.missions.world import World
from ods.offline.mission import Detecting, Found, MissionSettings, Tracking
from ods.offline.poses import SIGMA_ATTITUDE_RAD, SIGMA_POSITION_M
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.ins.place import over_bottom
from ods.sim_sonar.ins.sigmas import USUAL_SIGMAS
from ods.sim_sonar.range_image import RangeImages
from ods.sim_sonar.receiver.blindness import BLINDNESS
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.shots import START_UTC_NS
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.steered import SteeredVehicle, VehicleState
from ods.tracker.clearance.clearance import ClearanceKeeper

SECTORS = 72
STILL = (0.0, 0.0, 0.0)
STEPS = 4
"""Of the vehicle, from ping to ping."""
POSE_STEPS = 2
"""Steps of the vehicle from pose to pose."""
NO_ERRORS = ErrorSettings()


class Received(NamedTuple):
    """The planner's input after a ping."""

    list: ObstacleList
    clearance: Clearance | None


class Watch(Protocol):
    """Observes the world from the vehicle."""

    def look(self, number: int, sent: VehicleState) -> Received | None:
        """Return what ping `number`, sent from there, led to, once the vehicle has gone on to the next; None: nothing.

        Raises OdsError.
        """


class TruthWatch:
    """Reports the true obstacles within the sonar's range, all around; with `blind` the pose only."""

    def __init__(self, world: World, range_m: float, *, blind: bool = False) -> None:
        self._world, self._range_m, self._blind = world, range_m, blind

    def look(self, number: int, sent: VehicleState) -> Received:
        """Return the planner's input at that time."""
        t_s, t_ns, pose = sent.t_s, round(sent.t_s * NS), pose_of(sent)
        near = []
        if not self._blind:
            away = self._world.clearances(t_s, *pose.position_ned)
            near = np.flatnonzero(away < self._range_m).tolist()
        places, down = self._world.places(t_s), self._world.settings.down_m
        obstacles = [self._obstacle(which, (*places[which].tolist(), down)) for which in near]
        truth = ObstacleList(number, number, t_ns, t_ns, t_ns, True, [], obstacles, made_ns=t_ns, pose=pose)
        reach = [self._range_m] * SECTORS
        return Received(
            truth, Clearance(number, number, t_ns, t_ns, True, [0.0] * SECTORS, reach, [None] * SECTORS, pose=pose)
        )

    def _obstacle(self, which: int, place: tuple[float, float, float]) -> Obstacle:
        north, east = self._world.velocity[which].tolist()
        radius = float(self._world.radius_m[which])
        return Obstacle(which, "active", place, (north, east, 0.0), radius, STILL, STILL, 0.0, 0, 0, 1, 1.0)


class Finding(Protocol):
    """Makes detections of the world."""

    def found(self, number: int, sent: VehicleState) -> Found:
        """Return what is found in ping `number`, sent from there, and the poses until its end. Raises OdsError."""


class InImages:
    """The pipeline, as on board, on simulated images."""

    def __init__(
        self,
        scene: Scene,
        poses: Iterator[Pose],
        sonar: SonarModel,
        settings: MissionSettings,
        errors: ErrorSettings = NO_ERRORS,
    ) -> None:
        """Raises ValueError where sonar and world do not fit, PluginError, StageError."""
        self._errors = errors
        self._images = ImageSimulator(sonar, scene) if sonar.pixels is None else RangeImages(sonar, scene)
        self._next: tuple[int, float] = (0, 0.0)
        self._image_s = 0.0
        self._found = Detecting(settings).found(self._pings(), poses)

    def found(self, number: int, sent: VehicleState) -> Found:
        """Return the pipeline's detections."""
        self._next = number, sent.t_s
        began, self._image_s = time.thread_time(), 0.0
        found = next(self._found)[1]
        return found._replace(chain_ms=1e3 * (time.thread_time() - began - self._image_s))

    def _pings(self) -> Iterator[Ping]:
        while True:
            number, t_s = self._next
            t_ns = round(t_s * NS)
            began = time.thread_time()
            if isinstance(self._images, ImageSimulator):
                self._images.blindness = [BLINDNESS[kind] for kind in self._errors.faults_at(t_s)]
            ping = self._errors.ping(self._images.ping(t_s, number, t_ns, START_UTC_NS + t_ns))
            self._image_s += time.thread_time() - began
            yield ping


class ByLaws:
    """Detections drawn by laws that were fitted to images and pipeline."""

    def __init__(
        self, world: World, vehicle: SteeredVehicle, poses: Iterator[Pose], sonar: SonarModel, laws: Laws
    ) -> None:
        rng = np.random.default_rng(np.random.SeedSequence(world.seed, spawn_key=(2,)))
        self._world, self._vehicle, self._poses = world, vehicle, poses
        self._fan = fan_of(sonar)
        self._drawing = Drawing(laws, len(world.radius_m), self._fan, rng)
        self._listens_s = 2.0 * sonar.range_max_m / sonar.sound_speed
        self._received_ns = -1

    def found(self, number: int, sent: VehicleState) -> Found:
        """Return drawn detections."""
        t_ns = round(sent.t_s * NS)
        ended_ns = t_ns + round(self._listens_s * NS)
        began = time.thread_time()
        sights = sights_of(self._world, self._vehicle, sent.t_s, self._fan)
        at = head_of(self._vehicle, sent.t_s + self._listens_s)
        found = self._drawing.detections(number, t_ns, START_UTC_NS + t_ns, sights, at)
        spent_ms = 1e3 * (time.thread_time() - began)
        received = []
        while self._received_ns < ended_ns:
            received.append(next(self._poses))
            self._received_ns = received[-1].t_ns
        return Found(number, t_ns, START_UTC_NS + t_ns, ended_ns, received, found, spent_ms)


class OnBoard:
    """Tracker and clearance, as on board, on these detections."""

    def __init__(
        self,
        world: World,
        vehicle: SteeredVehicle,
        sonar: SonarModel,
        settings: MissionSettings,
        laws: Laws | None = None,
        errors: ErrorSettings = NO_ERRORS,
    ) -> None:
        """`laws`: to draw detections by; none: they are found in images; `errors`: what is not known on board.

        Raises ValueError where sonar and world do not fit, PluginError, StageError.
        """
        self._vehicle, self._errors = vehicle, errors
        self._scene = scene_of(world, vehicle, errors.mounting or settings.mounting)
        self._noise = np.random.default_rng(np.random.SeedSequence(world.seed, spawn_key=(1,)))
        self._tracking = Tracking(settings)
        self._keeper = ClearanceKeeper(settings.tracker.clearance)
        poses = self._poses()
        self._finding: Finding = (
            InImages(self._scene, poses, sonar, settings, errors)
            if laws is None
            else ByLaws(world, vehicle, poses, sonar, laws)
        )
        self.newest: Found | None = None
        """Of the newest ping."""
        self.finding_ms: list[float] = []
        """CPU time of the pipeline, or of drawing detections, for each ping."""
        self.tracking_ms: list[float] = []
        """CPU time of the tracker for each ping."""

    def look(self, number: int, sent: VehicleState) -> Received | None:
        """Return the list of a ping."""
        found = self.newest = self._finding.found(number, sent)
        began = time.thread_time()
        found_list = self._tracking.list_of(found)
        self.tracking_ms.append(1e3 * (time.thread_time() - began))
        self.finding_ms.append(found.chain_ms)
        return None if found_list is None else Received(found_list, self._keeper.after(found_list, found.detections))

    def _poses(self) -> Iterator[Pose]:
        """Yield the vehicle's poses, for ever: it has always gone on beyond the last echo."""
        for number in count():
            state = self._vehicle.way[POSE_STEPS * number]
            t_ns = round(state.t_s * NS)
            over = over_bottom(self._scene, np.array(state.place))
            if over is not None:
                over = max(0.0, over + USUAL_SIGMAS.over_bottom * self._noise.standard_normal())
            pose = Pose(
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
            yield self._errors.pose(pose)


def watch_of(
    arm: Arm,
    world: World,
    vehicle: SteeredVehicle,
    sonar: SonarModel,
    settings: MissionSettings,
    laws: Laws | None = None,
    errors: ErrorSettings = NO_ERRORS,
) -> Watch:
    """Return an arm's observation of the world. Raises ValueError, PluginError, StageError."""
    if arm == "ods":
        return OnBoard(world, vehicle, sonar, settings, laws, errors)
    return TruthWatch(world, sonar.range_max_m, blind=arm != "truth")


def head_of(vehicle: SteeredVehicle, t_s: float) -> Placed:
    """Return where the sonar's head is at a time."""
    north, east, _ = vehicle.position(np.array(t_s)).tolist()
    w, _, _, z = vehicle.attitude(np.array(t_s)).tolist()
    return Placed(north, east, 2.0 * math.atan2(z, w))


def pose_of(state: VehicleState) -> PoseAt:
    """Return the vehicle's true pose."""
    return PoseAt(state.place, state.attitude, state.velocity_ned, STILL, STILL)
