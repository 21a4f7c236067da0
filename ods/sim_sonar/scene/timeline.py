"""A scene: positions of all objects at any time, from config/scenes/NAME.toml."""

import copy
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.base.frames.mounting import Mounting, MountingSettings
from ods.base.settings_file import ConfigError, load
from ods.sim_sonar.echo.bodies.bodies import (
    BODY,
    CYLINDER,
    PLANE,
    SPHERE,
    UNBOUNDED,
    Bodies,
    circle_radius,
    contains,
)
from ods.sim_sonar.pose import Times, VehiclePose
from ods.sim_sonar.scene.motion import Motions, Moving, VehicleMotion
from ods.sim_sonar.scene.settings import Cylinder, Plane, SceneFile, Sphere
from ods.sim_sonar.sea_bed.model import sea_bed_of

CHECK_STEP_S = 0.25
"""Time between the instants at which a scene is checked."""
MAX_CHECKS = 4000


@dataclass(frozen=True, eq=False)
class VehicleState:
    """The vehicle at one time."""

    position_ned: Floats
    """(3,) m."""
    attitude: Floats
    """(4,) unit quaternion, body to global."""
    velocity_body: Floats
    """(3,) FRD, m/s: the derivative of position, turned into the body frame."""


@dataclass(frozen=True, eq=False)
class ObjectStates:
    """All bounded objects at one time; walls (planes without bounds) have no place and no circle."""

    names: tuple[str, ...]
    position_ned: Floats
    """(n, 3) centres, m."""
    velocity_ned: Floats
    """(n, 3) m/s."""
    radius_m: Floats
    """(n,) of the circle that circumscribes the object seen from above."""


class Scene:
    """A checked scene. Raises ValueError, one line, for one that cannot be."""

    def __init__(
        self, file: SceneFile, mounting: MountingSettings | None = None, vehicle: Moving | None = None
    ) -> None:
        """`mounting`: the sonar's, where the scene has none; `vehicle`: one that goes its own way, not the scene's.

        Where such a one goes is not known before, and not checked.
        """
        self.file = file
        self._mounting = Mounting(file.vehicle.mounting or mounting or MountingSettings())
        self.sea_bed = sea_bed_of(file.sea_bed, file.seed) if file.sea_bed is not None else None
        self._vehicle: Moving = VehicleMotion(file.vehicle) if vehicle is None else vehicle
        self._paths = Motions(file.objects)
        self._bodies = np.concatenate([np.empty(0, BODY), *(_body(item) for item in file.objects)])
        self.shown = [i for i, item in enumerate(file.objects) if not _is_wall(item)]
        """Those of `bodies_at` that `objects_at` has: bounded objects."""
        self._names = tuple(file.objects[i].name for i in self.shown)
        self._radius = np.array([circle_radius(self._bodies[i]) for i in self.shown])
        if vehicle is None:
            self._check()

    def pose_at(self, t_s: Times) -> VehiclePose:
        """Return the vehicle's poses at times (...)."""
        return VehiclePose(self._vehicle.position(t_s), self._vehicle.attitude(t_s))

    def head_at(self, t_s: Times) -> VehiclePose:
        """Return the poses of the sonar's head at times (...)."""
        vehicle = self.pose_at(t_s)
        return vehicle if self._mounting.is_none else VehiclePose(*self._mounting.heads(*vehicle))

    def with_head_turned(self, angle_rad: float) -> "Scene":
        """Return the same scene with the sonar's head turned to its starboard, as one that is scanned is."""
        other = copy.copy(self)
        other._mounting = self._mounting.with_head_turned(angle_rad)
        return other

    def vehicle_at(self, t_s: float) -> VehicleState:
        """Return the vehicle's state at scene time `t_s`."""
        position, attitude = self.pose_at(t_s)
        velocity_body = self._vehicle.velocity(t_s) @ geometry.rotation_matrix(attitude)
        return VehicleState(position, attitude, velocity_body)

    def objects_at(self, t_s: float) -> ObjectStates:
        """Return where the bounded objects are at scene time `t_s`."""
        return ObjectStates(
            self._names,
            self._paths.positions(t_s)[self.shown],
            np.array([self._paths.each[i].velocity(t_s) for i in self.shown]).reshape(-1, 3),
            self._radius,
        )

    def bodies_at(self, t_s: float) -> Bodies:
        """Return all objects at `t_s`, in NED."""
        bodies = self._bodies.copy()
        bodies["centre"] = self._paths.positions(t_s)
        return bodies

    def _check(self) -> None:
        """Refuse a sonar under the sea-bed or inside an object at any time of the mission."""
        steps = min(MAX_CHECKS, math.ceil(self.file.duration_s / CHECK_STEP_S)) + 1
        times = np.linspace(0.0, self.file.duration_s, steps)
        for t_s, place in zip(times, self.head_at(times).position_ned, strict=True):
            if self.sea_bed is not None and not self.sea_bed.is_above(place):
                raise ValueError(f"sea_bed.depth_m: the sonar is below the sea-bed at t = {t_s:.2f} s")
            for body, item in zip(self.bodies_at(float(t_s)), self.file.objects, strict=True):
                if contains(body, place):
                    raise ValueError(f"objects: {item.name!r} encloses the sonar at t = {t_s:.2f} s")


def load_scene(path: Path, mounting: MountingSettings | None = None, vehicle: Moving | None = None) -> Scene:
    """Read a scene file; `mounting` and `vehicle` as for `Scene`. Raises ConfigError."""
    file = load(path, SceneFile)
    try:
        return Scene(file, mounting, vehicle)
    except ValueError as error:
        raise ConfigError(f"{path}: {error}") from error


def _is_wall(item: Sphere | Cylinder | Plane) -> bool:
    return isinstance(item, Plane) and item.width_m is None


def _body(item: Sphere | Cylinder | Plane) -> Bodies:
    """Return an object, (1,), its centre still at the origin."""
    body = np.zeros(1, BODY)
    body["axes"] = np.eye(3)
    if isinstance(item, Sphere):
        body["kind"], body["half"] = SPHERE, item.radius_m
    elif isinstance(item, Cylinder):
        body["kind"], body["half"] = CYLINDER, (item.radius_m, item.radius_m, 0.5 * item.length_m)
        body["axes"] = _axes_of(np.array(item.axis_ned))
    else:
        size = [UNBOUNDED if side is None else 0.5 * side for side in (item.width_m, item.height_m)]
        body["kind"], body["half"] = PLANE, (size[0], size[1], 0.0)
        body["axes"] = _axes_of(np.array(item.normal_ned))
    surface = item.surface
    body["cd"], body["cs"], body["sigma_rad"] = surface.cd, surface.cs, math.radians(surface.sigma_deg)
    return body


def _axes_of(direction: Floats) -> Floats:
    """Return local axes (rows) whose z is along `direction` and whose x is level, north where z is vertical."""
    z = direction / np.linalg.norm(direction)
    level = np.array([-z[1], z[0], 0.0])
    x = np.array([1.0, 0.0, 0.0]) if np.linalg.norm(level) < 1e-9 else level / np.linalg.norm(level)
    return np.stack([x, np.cross(z, x), z])
