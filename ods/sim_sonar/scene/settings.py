"""What config/scenes/*.toml may say."""

import math
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Annotated

import msgspec

from ods.base.settings import NonNegative, NonNegativeInt, Positive, Settings
from ods.sim_sonar.receiver.settings import ImageLevels

Triple = tuple[float, float, float]


class Waypoint(Settings, frozen=True, kw_only=True):
    """A place and the time to be there."""

    t_s: float
    """Scene time, s."""
    position_ned: Triple
    """North, east, down, m."""


class Path(Settings, frozen=True, kw_only=True):
    """A path in time: constant velocity from `position_ned`, or a smooth curve through `waypoints`."""

    position_ned: Triple | None = None
    """Place at scene time 0: north, east, down, m."""
    velocity_ned: Triple = (0.0, 0.0, 0.0)
    """Constant velocity from there, m/s."""
    waypoints: list[Waypoint] = msgspec.field(default_factory=list)
    """Two or more, instead of position_ned; before and after them the end velocities hold."""

    def __post_init__(self) -> None:
        if (self.position_ned is None) == (not self.waypoints):
            raise ValueError("position_ned: give either position_ned (and velocity_ned) or waypoints")
        if self.waypoints and self.velocity_ned != (0.0, 0.0, 0.0):
            raise ValueError("velocity_ned: goes with position_ned, not with waypoints")
        if len(self.waypoints) == 1:
            raise ValueError("waypoints: at least 2")
        if any(b.t_s <= a.t_s for a, b in pairwise(self.waypoints)):
            raise ValueError("waypoints: t_s must rise strictly")


class Oscillation(Settings, frozen=True, kw_only=True):
    """A sine about the mean: amplitude_deg * sin(2 pi t / period_s + phase_deg)."""

    amplitude_deg: Annotated[float, msgspec.Meta(ge=0.0, le=60.0)] = 0.0
    """Degrees."""
    period_s: Positive = 10.0
    """Seconds."""
    phase_deg: float = 0.0
    """Degrees."""


class VehiclePath(Path, frozen=True, kw_only=True):
    """The vehicle's path and attitude; the sonar sits at its origin and looks along its bow."""

    heading_deg: float = 0.0
    """Mean heading, degrees from north to east."""
    follow_path: bool = False
    """Head along the horizontal velocity instead, wherever there is one."""
    roll: Oscillation = Oscillation()
    """Roll about 0."""
    pitch: Oscillation = Oscillation()
    """Pitch about 0."""
    yaw: Oscillation = Oscillation()
    """Yaw about the heading."""


class Surface(Settings, frozen=True, kw_only=True):
    """How a surface reflects (eq. 3)."""

    cd: NonNegative = 0.3
    """Diffuse share Cd."""
    cs: NonNegative = 0.3
    """Specular share Cs."""
    sigma_deg: Annotated[float, msgspec.Meta(gt=0.0, le=90.0)] = 15.0
    """Surface roughness: standard deviation of the facets' slope, degrees."""


class _Object(Path, frozen=True, kw_only=True, tag_field="shape"):
    """What all objects have: a name, a surface, a path of their centre."""

    name: Annotated[str, msgspec.Meta(min_length=1)]
    """Unique in its scene."""
    surface: Surface = Surface()
    """How it reflects."""


class Sphere(_Object, frozen=True, kw_only=True, tag="sphere"):
    """A sphere."""

    radius_m: Positive
    """m."""


class Cylinder(_Object, frozen=True, kw_only=True, tag="cylinder"):
    """A cylinder with flat end caps."""

    radius_m: Positive
    """m."""
    length_m: Positive
    """Along the axis, m."""
    axis_ned: Triple = (0.0, 0.0, 1.0)
    """Direction of the axis, any length but zero."""

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse_zero("axis_ned", self.axis_ned)


class Plane(_Object, frozen=True, kw_only=True, tag="plane"):
    """A flat rectangle, seen from both sides; without width_m and height_m it has no bounds (a wall)."""

    normal_ned: Triple
    """Direction of the normal, any length but zero."""
    width_m: Positive | None = None
    """Horizontal side (the northern one where the normal is vertical), m."""
    height_m: Positive | None = None
    """The other side, m."""

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse_zero("normal_ned", self.normal_ned)
        if (self.width_m is None) != (self.height_m is None):
            raise ValueError("width_m: give both width_m and height_m, or neither")


def _refuse_zero(key: str, vector: Triple) -> None:
    if math.hypot(*vector) < 1e-9:
        raise ValueError(f"{key}: a direction of zero length")


class Roughness(Settings, frozen=True, kw_only=True):
    """Gaussian heights above the sea-bed's plane, with the correlation exp(-r^2 / correlation_m^2)."""

    rms_height_m: NonNegative
    """Root mean square height, m."""
    correlation_m: Positive
    """Correlation length, m; the rms slope is 1.41 rms_height_m / correlation_m in each direction."""
    seed: NonNegativeInt | None = None
    """Seed of the heights; the scene's own by default."""
    facets: Annotated[int, msgspec.Meta(ge=8, le=2000)] = 512
    """Facets along each side of the square after which the heights repeat."""
    facet_m: Positive | None = None
    """Side of a facet, m; a quarter of the correlation length by default."""


class SeaBed(Settings, frozen=True, kw_only=True):
    """A sea-bed: a plane, level or not, with or without heights above it."""

    depth_m: float
    """Down coordinate of the plane at north 0, east 0, m."""
    slope_deg: Annotated[float, msgspec.Meta(ge=0.0, le=30.0)] = 0.0
    """Mean slope, degrees."""
    slope_heading_deg: float = 0.0
    """Heading towards which the plane falls, degrees."""
    rough: Roughness | None = None
    """Random heights."""
    file: FilePath | None = None
    """Heights from an .npz file instead, relative to the scene file."""
    surface: Surface = Surface()
    """How it reflects."""

    def __post_init__(self) -> None:
        if self.rough is not None and self.file is not None:
            raise ValueError("rough: give either rough or file")


class SceneFile(Settings, frozen=True, kw_only=True):
    """A scene: config/scenes/NAME.toml."""

    seed: NonNegativeInt
    """Seed of everything random; the same seed gives the same bytes."""
    duration_s: Positive = 60.0
    """Length of the mission, s; the scene is checked over it."""
    shadows: bool = True
    """Nearer objects hide what lies behind them; false: everything is seen, as if transparent."""
    vehicle: VehiclePath
    """The vehicle."""
    objects: list[Sphere | Cylinder | Plane] = msgspec.field(default_factory=list)
    """Any number."""
    sea_bed: SeaBed | None = None
    """None: open water."""
    image: ImageLevels = ImageLevels()
    """Levels and noise."""

    def __post_init__(self) -> None:
        seen: set[str] = set()
        for item in self.objects:
            if item.name in seen:
                raise ValueError(f"objects: two objects are called {item.name!r}")
            seen.add(item.name)
