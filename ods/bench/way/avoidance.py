"""Judges how a steered vehicle came through: its true way against the scene. Pure."""

import math
from itertools import pairwise
from typing import NamedTuple

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.bench.settings import AvoidLimits
from ods.messages import Vector3, VehicleSetPoint, VehicleTruth
from ods.offline.run_record import Log
from ods.planner.settings import SteeringSettings
from ods.sim_sonar.echo.bodies.bodies import clearances
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.settings import VehicleSettings


class Mission(NamedTuple):
    """The task and its world."""

    scene: Scene
    way_points: list[Vector3]
    steering: SteeringSettings
    can: VehicleSettings
    """Of the vehicle."""
    current_m_s: tuple[float, float]
    """North, east."""
    keep_m: float
    """What an all-knowing planner keeps from objects."""


class Avoidance(msgspec.Struct, frozen=True):
    """The figures of a steered mission."""

    arrived: bool
    """At the last way-point, by the planner."""
    clearance_m: float
    """Least distance between the vehicle's circle and any object; below 0: a collision."""
    nearest: str
    """The object that it came so near to."""
    over_bottom_m: float
    """Least height over the sea-bed; infinite where there is none."""
    path_m: float
    """Length of the way over ground."""
    straight_ratio: float
    """Over the straight way from the start over all way-points, as far as where the last one counts as reached."""
    path_ratio: float
    """Over the way of an all-knowing planner; where none was found, over the straight one."""
    seconds: float
    """From the start to the arrival, or the end."""
    evasions: int
    """Times that something listed in the way made the planner leave its course."""
    not_valid_s: float
    """Time during which the planner had no list to rely on."""
    stopped_s: float
    """Time during which the vehicle's watchdog had stopped it."""


def clearance_of(mission: Mission, truth: VehicleTruth) -> Floats:
    """Return (n,) how far the vehicle's circle is from each object, m."""
    place = np.array(truth.position_ned)
    return clearances(mission.scene.bodies_at(truth.scene_s), place) - mission.can.radius_m


def judge(
    mission: Mission, way: Log[VehicleTruth], set_points: Log[VehicleSetPoint], best_m: float | None
) -> Avoidance:
    """Return the figures of a mission, as far as the arrival; `best_m`: length of an all-knowing planner's way."""
    arrival_ns = next((each.t_ns for each in set_points if each.arrived), None)
    flown = [each for each in way if arrival_ns is None or each.t_ns <= arrival_ns]
    received = [each for each in set_points if arrival_ns is None or each.t_ns <= arrival_ns]
    clear, nearest, bottom = _nearest(mission, flown)
    path_m = sum(math.dist(a.position_ned, b.position_ned) for a, b in pairwise(flown))
    straight_ratio = _straight_ratio(path_m, flown, mission)
    return Avoidance(
        arrived=arrival_ns is not None,
        clearance_m=clear,
        nearest=nearest,
        over_bottom_m=bottom,
        path_m=path_m,
        straight_ratio=straight_ratio,
        path_ratio=path_m / best_m if best_m and flown else straight_ratio,
        seconds=flown[-1].scene_s - flown[0].scene_s if flown else 0.0,
        evasions=sum(now.avoiding and not was.avoiding for was, now in pairwise(received)),
        not_valid_s=sum((now.t_ns - was.t_ns) * 1e-9 for was, now in pairwise(received) if not was.valid),
        stopped_s=sum((now.t_ns - was.t_ns) * 1e-9 for was, now in pairwise(flown) if was.stopped),
    )


def missed(found: Avoidance, limits: AvoidLimits) -> dict[str, str]:
    """Return the limits that were not reached, by name, in plain words."""
    said = {}
    if found.clearance_m < 0.0:
        said["collision"] = f"it collided with {found.nearest}"
    elif not found.clearance_m >= limits.clearance_m:
        text = f"clearance_m is {found.clearance_m:.2f} ({found.nearest}), the limit is {limits.clearance_m:g}"
        said["clearance_m"] = text
    if not found.over_bottom_m >= limits.over_bottom_m:
        said["over_bottom_m"] = f"over_bottom_m is {found.over_bottom_m:.2f}, the limit is {limits.over_bottom_m:g}"
    if not found.arrived:
        said["arrived"] = f"it did not arrive in {found.seconds:.0f} s"
    elif not found.path_ratio <= limits.path_ratio:
        said["path_ratio"] = f"path_ratio is {found.path_ratio:.3f}, the limit is {limits.path_ratio:g}"
    return said


def _nearest(mission: Mission, flown: list[VehicleTruth]) -> tuple[float, str, float]:
    """Return the least clearance, the object that it was to, and the smallest height over the bottom."""
    clear, nearest, bottom = math.inf, "", math.inf
    bed = mission.scene.sea_bed
    for truth in flown:
        each = clearance_of(mission, truth)
        if each.size and each.min() < clear:
            clear, nearest = float(each.min()), mission.scene.file.objects[int(each.argmin())].name
        if bed is not None:
            bottom = min(bottom, bed.altitude_of(np.array(truth.position_ned)))
    return clear, nearest, bottom


def _straight_ratio(path_m: float, flown: list[VehicleTruth], mission: Mission) -> float:
    if not flown:
        return math.inf
    points = [flown[0].position_ned, *mission.way_points]
    straight = sum(math.dist(a, b) for a, b in pairwise(points)) - mission.steering.reached_m
    return path_m / straight if straight > 0.0 else math.inf
