"""Settings in config/scenes/*.toml."""

import math
from itertools import pairwise
from typing import Annotated

import msgspec

from ods.base.frames.mounting import MountingSettings
from ods.base.settings import NonNegativeInt, Positive, Settings
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.sea_bed.settings import SeaBed

Triple = tuple[float, float, float]


class Waypoint(Settings, frozen=True, kw_only=True):
    """A position and the time at which it is reached."""

    t_s: float
    """Scene time."""
    position_ned: Triple
    """m."""


class Path(Settings, frozen=True, kw_only=True):
    """A path in time: constant velocity from `position_ned`, or a smooth curve through `waypoints`."""

    position_ned: Triple | None = None
    """Place at scene time 0, m."""
    velocity_ned: Triple = (0.0, 0.0, 0.0)
    """Constant velocity from there, m/s."""
    waypoints: list[Waypoint] = msgspec.field(default_factory=list)
    """Two or more, instead of position_ned; before and after them the velocity is constant."""

    def __post_init__(self) -> None:
        if (self.position_ned is None) == (not self.waypoints):
            raise ValueError("position_ned: set either position_ned (with velocity_ned) or waypoints")
        if self.waypoints and self.velocity_ned != (0.0, 0.0, 0.0):
            raise ValueError("velocity_ned: use it with position_ned, not with waypoints")
        if len(self.waypoints) == 1:
            raise ValueError("waypoints: at least 2")
        if any(b.t_s <= a.t_s for a, b in pairwise(self.waypoints)):
            raise ValueError("waypoints: t_s must increase strictly")


class Oscillation(Settings, frozen=True, kw_only=True):
    """amplitude_deg * sin(2 pi t / period_s + phase_deg)."""

    amplitude_deg: Annotated[float, msgspec.Meta(ge=0.0, le=60.0)] = 0.0
    period_s: Positive = 10.0
    phase_deg: float = 0.0


class VehiclePath(Path, frozen=True, kw_only=True):
    """The vehicle and its sonar."""

    heading_deg: float = 0.0
    """Mean, from north to east."""
    follow_path: bool = False
    """Head along the horizontal velocity instead."""
    roll: Oscillation = Oscillation()
    """Roll about 0."""
    pitch: Oscillation = Oscillation()
    """Pitch about 0."""
    yaw: Oscillation = Oscillation()
    """Yaw about the heading."""
    mounting: MountingSettings | None = None
    """Left out: as `[sonar.mounting]` on the bench, else at the vehicle's origin, looking ahead."""


class _Object(Path, frozen=True, kw_only=True, tag_field="shape"):
    """What all objects have: a name, a surface, a path of their centre."""

    name: Annotated[str, msgspec.Meta(min_length=1)]
    """Unique in its scene."""
    surface: Surface = Surface()
    """How it reflects."""


class Sphere(_Object, frozen=True, kw_only=True, tag="sphere"):
    """A sphere."""

    radius_m: Positive


class Cylinder(_Object, frozen=True, kw_only=True, tag="cylinder"):
    """A cylinder with flat end caps."""

    radius_m: Positive
    length_m: Positive
    """Along the axis."""
    axis_ned: Triple = (0.0, 0.0, 1.0)
    """Any length but zero."""

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse_zero("axis_ned", self.axis_ned)


class Plane(_Object, frozen=True, kw_only=True, tag="plane"):
    """A flat rectangle, seen from both sides; without width_m and height_m unbounded (a wall)."""

    normal_ned: Triple
    """Any length but zero."""
    width_m: Positive | None = None
    """Horizontal side (the northern one where the normal is vertical)."""
    height_m: Positive | None = None
    """The other side."""

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse_zero("normal_ned", self.normal_ned)
        if (self.width_m is None) != (self.height_m is None):
            raise ValueError("width_m: give both width_m and height_m, or neither")


def _refuse_zero(key: str, vector: Triple) -> None:
    if math.hypot(*vector) < 1e-9:
        raise ValueError(f"{key}: a direction of zero length")


class SceneFile(Settings, frozen=True, kw_only=True):
    """A scene: config/scenes/NAME.toml."""

    seed: NonNegativeInt
    """The same seed gives the same bytes."""
    duration_s: Positive = 60.0
    shadows: bool = True
    """Nearer objects hide what lies behind them."""
    vehicle: VehiclePath
    """The vehicle."""
    objects: list[Sphere | Cylinder | Plane] = msgspec.field(default_factory=list)
    sea_bed: SeaBed | None = None
    """None: open water."""
    image: ImageLevels = ImageLevels()
    """Levels and noise."""

    def __post_init__(self) -> None:
        seen: set[str] = set()
        for item in self.objects:
            if item.name in seen:
                raise ValueError(f"objects: two objects have the name {item.name!r}")
            seen.add(item.name)
