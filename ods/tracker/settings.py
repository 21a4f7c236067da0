"""Settings of the `tracker` package: what `[tracker]` in config/onboard.toml may say."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from ods.base.choices import none_of
from ods.base.geodesy import SiteSettings
from ods.base.mounting import MountingSettings
from ods.base.plugins import PluginGroup
from ods.base.settings import NonNegative, NonNegativeInt, NonNegativeSeconds, Positive, PositiveInt, Settings, slider
from ods.runtime.pose_buffer import PoseSettings

REST = 0.5
"""An object out of view goes into the map if its velocity cannot be told from zero: it is not more likely to move;"""
STATIC = 0.95
"""An object is fit for the map if its velocity cannot be told from zero: it is static with this probability."""

OWN_OBSERVERS = frozenset({"independent", "coupled", "manoeuvring"})
OWN_ASSOCIATIONS = frozenset({"nearest", "probabilistic"})
"""Known without loading the registers, which may have more."""
PLUGINS = PluginGroup("tracker.plugins", "ods.tracker")
"""Where observers and associations of the user's own are named."""

Probability = Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)]


class MotionSettings(Settings, frozen=True):
    """How objects move: the process noise of the Kalman filters."""

    velocity_sigma: Annotated[Positive, slider(0.01, 10.0, log=True, unit="m/s")] = 1.0
    """Standard deviation of a new object's velocity, each of north and east, if it moves at all, m/s."""
    vertical_velocity_sigma: Annotated[Positive, slider(0.01, 3.0, log=True, unit="m/s")] = 0.3
    """The same, down, m/s."""
    acceleration_noise: Annotated[NonNegative, slider(0.0, 1.0, step=1e-5, log=True, unit="m^2/s^3")] = 0.01
    """Spectral density of a moving object's acceleration, m^2/s^3."""
    steady_noise: Annotated[NonNegative, slider(0.0, 1e-3, step=1e-8, log=True, unit="m^2/s^3")] = 1e-6
    """The same of an object that keeps its velocity; only `manoeuvring` tells it from others."""
    static_noise: Annotated[NonNegative, slider(0.0, 1e-3, step=1e-8, log=True, unit="m^2/s")] = 2e-6
    """Spectral density of a static object's drift (it stands for drift of the pose), m^2/s."""
    radius_noise: Annotated[NonNegative, slider(0.0, 0.1, step=1e-5, log=True, unit="m^2/s")] = 1e-3
    """Spectral density of changes of the radius, which depends on the aspect, m^2/s."""
    static_prior: Annotated[Probability, slider(0.05, 0.95, step=0.05)] = 0.7
    """Share of static ones among new objects."""
    change_rate: Annotated[float, msgspec.Meta(ge=0.0, le=1.0), slider(0.0, 1.0, step=1e-4, log=True, unit="1/s")] = (
        0.001
    )
    """How often an object starts or stops moving, 1/s."""


class EchoSettings(Settings, frozen=True):
    """What the sonar and the pipeline make of objects, and of none."""

    detection_probability: Annotated[Probability, slider(0.05, 0.99, step=0.01)] = 0.9
    """Probability that an object in full view gives a detection."""
    clutter_per_scan: Annotated[Positive, slider(0.01, 100.0, log=True)] = 1.0
    """False alarms expected in a scan at the start; the tracker then counts them itself."""
    births_per_scan: Annotated[Positive, slider(0.001, 1.0, log=True)] = 0.03
    """New objects expected in a scan; against `clutter_per_scan` it says how much proof a new object needs."""
    births_at_start: Annotated[Positive, slider(0.001, 5.0, log=True)] = 0.3
    """The same in the very first images, where every object is new."""
    gate_sigmas: Annotated[float, msgspec.Meta(ge=1.0, le=10.0), slider(1.0, 10.0, step=0.1)] = 4.0
    """Largest distance of a detection from the object's predicted place, standard deviations."""
    silence_rate: Annotated[Positive, slider(0.001, 1.0, log=True, unit="1/s")] = 0.02
    """How often an object that gave echoes falls silent although in view (aspect, shadow), 1/s."""
    return_rate: Annotated[Positive, slider(0.001, 1.0, log=True, unit="1/s")] = 0.1
    """How often a silent object gives echoes again, 1/s."""
    loss_rate: Annotated[Positive, slider(1e-5, 0.1, log=True, unit="1/s")] = 1e-3
    """How often an object ceases to exist, 1/s."""


class LifeSettings(Settings, frozen=True):
    """When an object's state changes [SSIE figure 5]."""

    confirm_echoes: Annotated[int, msgspec.Meta(ge=2), slider(2, 10)] = 3
    """Echoes before a new object is reported."""
    confirm_existence: Annotated[Probability, slider(0.5, 0.99, step=0.01)] = 0.98
    """Existence probability before a new object is reported."""
    drop_existence: Annotated[Probability, slider(0.05, 0.95, step=0.01)] = 0.4
    """A reported object below this existence probability is given up."""
    edge_sigmas: Annotated[NonNegative, slider(0.0, 5.0, step=0.1)] = 2.0
    """A missed echo counts only where the prediction is inside the sector by so many standard deviations."""
    silent_s: Annotated[Positive, slider(0.5, 30.0, step=0.5, unit="s")] = 3.0
    """An object in view goes to stand-by after so long without an echo."""
    stand_by_s: Annotated[Positive, slider(1.0, 120.0, step=1.0, unit="s")] = 10.0
    """An object out of view is hibernated (static) or terminated (moving) after so long without an echo."""
    lost_sigma_m: Annotated[Positive, slider(0.5, 20.0, step=0.5, unit="m")] = 4.0
    """The same when its position's standard deviation exceeds this."""


class PlannerSettings(Settings, frozen=True):
    """The obstacle list to the path planner."""

    period_s: Annotated[float, msgspec.Meta(gt=0.0, le=0.5), slider(0.05, 0.5, step=0.05, unit="s")] = 0.4
    """Time between lists while no detections come, s."""
    announce_ended: Annotated[PositiveInt, slider(1, 20, unit="lists")] = 5
    """Consecutive lists that report an ended object as `terminated`."""
    most_listed: Annotated[PositiveInt, slider(10, 2000, step=10)] = 1000
    """The list has the nearest so many objects; how many more there are is its `left_out`."""
    shape_sigma: Annotated[NonNegative, slider(0.0, 1.0, step=0.05)] = 0.2
    """Standard deviation of an object's horizontal place and radius that no number of echoes takes away, in units of
    its radius: a sonar sees the near side only, and the object's shape is not known."""
    hibernated_within_m: Annotated[NonNegative, slider(0.0, 500.0, step=10.0, unit="m")] = 150.0
    """Hibernated objects are listed up to this distance from the vehicle, m."""
    lead_times_s: Annotated[
        tuple[Annotated[NonNegative, slider(0.0, 120.0, unit="s")], ...], msgspec.Meta(max_length=20)
    ] = (5.0, 10.0, 20.0)
    """Each obstacle's position is predicted so far ahead, s."""
    approach_horizon_s: Annotated[Positive, slider(10.0, 600.0, step=10.0, unit="s")] = 300.0
    """The closest approach is looked for up to so far ahead, s."""


class BottomSettings(Settings, frozen=True):
    """What the planner hears of the bottom, where the vehicle's altitude over it is known."""

    clearance_m: Annotated[Positive, slider(0.1, 10.0, log=True, unit="m")] = 1.0
    """What reaches higher over the bottom is an obstacle, m."""
    list: Literal["hittable", "all"] = "hittable"
    """hittable: objects that reach no higher are left out of the list, once that is as good as certain (`risk`); all:
    none is."""
    risk: Annotated[Probability, slider(0.001, 0.1, log=True)] = 0.01
    """An object is left out only if it reaches higher with less than this probability."""
    slope_deg: Annotated[float, msgspec.Meta(ge=0.0, le=45.0), slider(0.0, 45.0, step=0.5, unit="deg")] = 5.0
    """Standard deviation of the bottom's mean slope from the vehicle to an object, degrees."""
    roughness_m: Annotated[NonNegative, slider(0.0, 2.0, step=0.05, unit="m")] = 0.2
    """Standard deviation of the bottom's height about that slope, m."""


class SurfaceSettings(Settings, frozen=True):
    """What the planner hears of the water's surface, where the fan meets it."""

    down_m: float = 0.0
    """Down coordinate of the surface, m: 0 where the site's heights count from there."""
    list: Literal["hittable", "all"] = "hittable"
    """hittable: objects that run as waves do, all alike and where the surface may be, are left out of the list; all:
    none is."""
    clearance_m: Annotated[Positive, slider(0.1, 10.0, log=True, unit="m")] = 1.0
    """What is known to hang lower under the surface is no wave, m."""


class ClearanceSettings(Settings, frozen=True):
    """The message `clearance`: what is known to be empty around the vehicle."""

    sectors: Annotated[int, msgspec.Meta(ge=8, le=360), slider(8, 360)] = 72
    """So many sectors of bearing, from north clockwise."""
    half_height_m: Annotated[NonNegative, slider(0.1, 5.0, log=True, unit="m")] = 0.3
    """Water counts as looked at where the fan covers so much above and below the vehicle's origin, m."""
    fastest_m_s: Annotated[Positive, slider(0.1, 10.0, log=True, unit="m/s")] = 2.0
    """Something so fast may come into water that is not looked at any more, m/s,"""
    fastest_vertical_m_s: Annotated[Positive, slider(0.05, 5.0, log=True, unit="m/s")] = 0.5
    """and so fast from above and below, m/s."""


class MapSettings(Settings, frozen=True):
    """The store of hibernated objects."""

    path: Path | None = None
    """SQLite file; none: the map ends with the process."""
    position_sigma_m: Annotated[NonNegative, slider(0.0, 5.0, step=0.1, unit="m")] = 0.5
    """Standard deviation added to the position of objects of an earlier mission, each of north and east, m."""
    minimum_times_seen: Annotated[NonNegativeInt, slider(0, 50)] = 5
    """Objects with fewer echoes are not worth storing for the next mission."""


class TrackerSettings(Settings, frozen=True):
    """Detections and pose to obstacles."""

    plugins: tuple[Path, ...] = ()
    """Python files, or modules by name, that register observers and associations of the user's own."""
    observer: str = "manoeuvring"
    """Name of the observer (the filters of an object's state)."""
    association: str = "probabilistic"
    """Which echo is whose: `nearest` (one echo each, the best sum) or `probabilistic` (all that may be its own)."""
    motion: MotionSettings = MotionSettings()
    echo: EchoSettings = EchoSettings()
    life: LifeSettings = LifeSettings()
    planner: PlannerSettings = PlannerSettings()
    bottom: BottomSettings = BottomSettings()
    surface: SurfaceSettings = SurfaceSettings()
    clearance: ClearanceSettings = ClearanceSettings()
    map: MapSettings = MapSettings()
    resume_within_s: Annotated[NonNegativeSeconds, slider(0.0, 60.0, step=1.0, unit="s")] = 10.0
    """A tracker that was killed goes on with its objects if it is up again within this time; 0: never."""

    def __post_init__(self) -> None:
        if self.observer not in OWN_OBSERVERS and not PLUGINS.may_add(self.plugins):
            from ods.tracker.observer.registry import OBSERVERS  # slow, and of use only where somebody has added one

            if self.observer not in OBSERVERS:
                raise ValueError(f"observer: {none_of(self.observer, OBSERVERS)}")
        if self.association not in OWN_ASSOCIATIONS and not PLUGINS.may_add(self.plugins):
            from ods.tracker.association.registry import ASSOCIATIONS

            if self.association not in ASSOCIATIONS:
                raise ValueError(f"association: {none_of(self.association, ASSOCIATIONS)}")
        if self.life.drop_existence >= self.life.confirm_existence:
            raise ValueError("life.drop_existence: must be below life.confirm_existence")


class TrackerConfig(Settings, frozen=True):
    """What the tracker process reads of the configuration."""

    site: SiteSettings
    pose: PoseSettings
    tracker: TrackerSettings
    mounting: MountingSettings = MountingSettings()
    """`[sonar.mounting]`."""
