"""Settings in a campaign's file."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from ods.base.settings import Fraction, NonNegative, NonNegativeInt, Positive, Settings
from ods.missions.failing.errors import ErrorSettings
from ods.pipeline.settings import PipelineSettings
from ods.planner.settings import SteeringSettings
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.sea_bed.settings import SeaBed
from ods.sim_sonar.settings import VehicleSettings
from ods.tracker.settings import TrackerSettings

Arm = Literal["none", "ods", "truth", "all_knowing"]
Metres = Annotated[float, msgspec.Meta(gt=0.0, le=5000.0)]
MOST_OBSTACLES = 2000


class WorldSettings(Settings, frozen=True):
    """Of what the worlds are made: obstacles in a box between start and goal, Poisson distributed."""

    length_m: Metres = 300.0
    """From start to goal, due north."""
    width_m: Metres = 120.0
    """Of the box."""
    obstacles_per_hectare: Annotated[float, msgspec.Meta(ge=0.0, le=1000.0)] = 5.0
    """Mean number in 10,000 m^2."""
    moving_share: Fraction = 0.3
    """Share of them that move, each with one velocity."""
    radius_m: tuple[Positive, Positive] = (0.5, 2.5)
    """Least and greatest radius: evenly distributed. They are upright cylinders."""
    speed_m_s: tuple[NonNegative, NonNegative] = (0.2, 1.0)
    """Least and greatest speed of those that move."""
    height_m: Positive = 10.0
    """Their reach above and below the vehicle's depth."""
    current_m_s: NonNegative = 0.3
    """Greatest speed of the current; its direction is random. What moves does so over ground."""
    down_m: Annotated[float, msgspec.Meta(ge=1.0, le=6000.0)] = 20.0
    """Depth that the vehicle is to keep."""
    free_start_m: NonNegative = 30.0
    """Least distance of an obstacle from the start, m."""
    free_goal_m: NonNegative = 15.0
    """Least distance of an obstacle from the goal, m."""
    dead_ends: Annotated[int, msgspec.Meta(ge=0, le=20)] = 0
    """Half circles of obstacles without a gap across the path, open towards the start, spaced evenly from start to
    goal."""
    dead_end_m: Metres = 12.0
    """Radius of these half circles."""
    heard_within_m: Positive | None = None
    """Obstacles echo only where the vehicle is nearer to their edges; none: as far as the sonar receives them."""
    surface: Surface = Surface(cd=0.1, cs=0.05, sigma_deg=15.0)
    """How obstacles reflect."""
    sea_bed: SeaBed | None = None
    """None: open water. Without a seed of its own, a rough one is another in each world."""
    image: ImageLevels = ImageLevels(max_error=0.1)
    """Levels and noise."""

    def __post_init__(self) -> None:
        for key, (low, high) in (("radius_m", self.radius_m), ("speed_m_s", self.speed_m_s)):
            if low > high:
                raise ValueError(f"{key}: the minimum is above the maximum")
        if self.sea_bed is not None and self.sea_bed.depth_m <= self.down_m:
            raise ValueError("sea_bed.depth_m: must be below down_m, where the vehicle goes")
        if self.obstacles_per_hectare * self.length_m * self.width_m / 1e4 > MOST_OBSTACLES:
            raise ValueError(f"obstacles_per_hectare: makes more than {MOST_OBSTACLES} obstacles a world")


class Variant(Settings, frozen=True):
    """One way of detecting and tracking, of a chart. What is left out is as in the campaign."""

    name: Annotated[str, msgspec.Meta(min_length=1, max_length=60)]
    varies: str = ""
    """What the chart's legend calls it; variants of one have one colour."""
    range_m: Metres | None = None
    pipeline: PipelineSettings | None = None
    tracker: TrackerSettings | None = None


class ChartSettings(Settings, frozen=True):
    """What `--chart` compares, in the same worlds."""

    speeds_m_s: Annotated[tuple[Positive, ...], msgspec.Meta(min_length=1)] = (1.0, 2.0, 3.0)
    """Cruise speeds of the vehicle."""
    fit_missions: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 4
    """Image-level missions to which the laws of each variant are fitted."""
    image_missions: Annotated[int, msgspec.Meta(ge=0, le=1_000_000)] = 0
    """Missions by images, of each variant at each speed, beside those by detections and in the same worlds."""
    variant: tuple[Variant, ...] = (Variant(name="as configured"),)

    def __post_init__(self) -> None:
        if len({each.name for each in self.variant}) < len(self.variant):
            raise ValueError("variant: two have the same name")


class Campaign(Settings, frozen=True):
    """CAMPAIGN.toml."""

    seed: NonNegativeInt
    """Of all worlds and of all that is random in them."""
    missions: Annotated[int, msgspec.Meta(ge=1, le=1_000_000)] = 100
    """Worlds; each arm goes through all of them."""
    arms: Annotated[tuple[Arm, ...], msgspec.Meta(min_length=1)] = ("none", "ods", "truth", "all_knowing")
    """none: no avoidance; ods: the list of pipeline and tracker; truth: a list of what is really there, in reach;
    all_knowing: no planner, the fastest way that a search finds which knows all motions."""
    sonar: str = "seabat6012"
    """Name of a file in config/sonars, or a path that ends in .toml."""
    range_m: Metres | None = None
    """Range that the sonar is set to: the shorter the more pings a second; none: its own."""
    onboard: Path | None = None
    """Configuration of pipeline and tracker; none: built-in settings."""
    pipeline: PipelineSettings | None = None
    """Pipeline settings in place of those of `onboard`."""
    tracker: TrackerSettings | None = None
    """Tracker settings in place of those of `onboard`."""
    fidelity: Literal["images", "detections"] = "images"
    """What the arm `ods` works on: simulated images, or detections drawn by laws that were fitted to them."""
    detections: Path | None = None
    """The laws, a file by --fit; for `fidelity = "detections"`."""
    near_miss_m: NonNegative = 1.0
    """Nearer than this without touching is a near miss."""
    longest: Annotated[float, msgspec.Meta(ge=1.0, le=100.0)] = 3.0
    """Longest duration of a mission, in multiples of the straight way at cruise speed."""
    world: WorldSettings = WorldSettings()
    errors: ErrorSettings = ErrorSettings()
    vehicle: VehicleSettings = VehicleSettings()
    planner: SteeringSettings = SteeringSettings()
    chart: ChartSettings = ChartSettings()

    def __post_init__(self) -> None:
        if len(set(self.arms)) < len(self.arms):
            raise ValueError("arms: one is listed twice")
        if self.planner.climb_to_m > self.world.down_m:
            raise ValueError("planner.climb_to_m: is below world.down_m: must be above it")
        if self.fidelity == "detections" and self.detections is None:
            raise ValueError('detections: fidelity = "detections" needs a file made by --fit')
        if self.fidelity == "detections" and self.errors != ErrorSettings():
            raise ValueError('errors: need fidelity = "images"')
        if self.fidelity == "detections" and self.world.heard_within_m is not None:
            raise ValueError('world.heard_within_m: needs fidelity = "images"')
