"""Settings of the `tracker` package: what `[tracker]` in config/onboard.toml may say."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from ods.base.choices import none_of
from ods.base.frames.mounting import MountingSettings
from ods.base.geodesy import SiteSettings
from ods.base.plugins import PluginGroup
from ods.base.settings import (
    Fraction,
    NonNegative,
    NonNegativeInt,
    NonNegativeSeconds,
    Positive,
    PositiveInt,
    Settings,
    slider,
)
from ods.pose.buffer import PoseSettings
from ods.runtime.bus import BusSettings

REST = 0.5
"""An object out of view is hibernated if it is static with at least this probability."""
STATIC = 0.95
"""A live object is stored in the map at the end of a mission if it is static with at least this probability."""
MARGIN_SIGMAS = 2.0
"""Standard deviations added to an object's or echo's position or size where the larger value is the safe one."""

OWN_OBSERVERS = ("independent", "coupled", "manoeuvring")
OWN_ASSOCIATIONS = ("nearest", "probabilistic")
"""Associations that come with ODS."""
OBSERVER_NAMES = dict.fromkeys(OWN_OBSERVERS)
ASSOCIATION_NAMES = dict.fromkeys(OWN_ASSOCIATIONS)
"""All that are known: the registries add the names of plug-ins."""
PLUGINS = PluginGroup("tracker.plugins", "ods.tracker")
"""Where the user's own observers and associations are named."""

Probability = Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)]


class MotionSettings(Settings, frozen=True):
    """Process noise of the Kalman filters."""

    velocity_sigma: Annotated[Positive, slider(0.01, 10.0, log=True, unit="m/s")] = 1.0
    """Of a new moving object, north and east, m/s."""
    vertical_velocity_sigma: Annotated[Positive, slider(0.01, 3.0, log=True, unit="m/s")] = 0.3
    """Of a new moving object, down, m/s."""
    acceleration_noise: Annotated[NonNegative, slider(0.0, 1.0, step=1e-5, log=True, unit="m^2/s^3")] = 0.01
    """Spectral density of a moving object's acceleration, m^2/s^3. More: follows manoeuvres sooner, knows steady
    motion less well."""
    steady_noise: Annotated[NonNegative, slider(0.0, 1e-3, step=1e-8, log=True, unit="m^2/s^3")] = 1e-6
    """The same of steady motion, m^2/s^3 (observer `manoeuvring`)."""
    static_noise: Annotated[NonNegative, slider(0.0, 1e-3, step=1e-8, log=True, unit="m^2/s")] = 2e-6
    """Spectral density of a static object's position, m^2/s: the drift of the pose."""
    radius_noise: Annotated[NonNegative, slider(0.0, 0.1, step=1e-5, log=True, unit="m^2/s")] = 1e-3
    """Spectral density of the radius, m^2/s."""
    static_prior: Annotated[Probability, slider(0.05, 0.95, step=0.05)] = 0.7
    """Share of static objects among new ones."""
    change_rate: Annotated[Fraction, slider(0.0, 1.0, step=1e-4, log=True, unit="1/s")] = 0.001
    """Rate at which an object starts or stops moving, 1/s."""


class EchoSettings(Settings, frozen=True):
    """Detections, missed detections and false alarms."""

    detection_probability: Annotated[Probability, slider(0.05, 0.99, step=0.01)] = 0.9
    """Probability that an object in full view is detected in a scan."""
    clutter_per_scan: Annotated[Positive, slider(0.01, 100.0, log=True)] = 1.0
    """Expected false alarms in a scan at the start; then estimated."""
    births_per_scan: Annotated[Positive, slider(0.001, 1.0, log=True)] = 0.03
    """Expected new objects per 0.15 s. A smaller number requires more evidence of a new object."""
    births_at_start: Annotated[Positive, slider(0.001, 5.0, log=True)] = 0.3
    """Expected new objects in each of the first two scans."""
    gate_sigmas: Annotated[float, msgspec.Meta(ge=1.0, le=10.0), slider(1.0, 10.0, step=0.1)] = 4.0
    """Largest distance of a detection from the prediction."""
    silence_rate: Annotated[Positive, slider(0.001, 1.0, log=True, unit="1/s")] = 0.02
    """Rate at which an object in view stops returning echoes (aspect, shadow), 1/s."""
    return_rate: Annotated[Positive, slider(0.001, 1.0, log=True, unit="1/s")] = 0.1
    """Rate at which a silent object returns echoes again, 1/s."""
    loss_rate: Annotated[Positive, slider(1e-5, 0.1, log=True, unit="1/s")] = 1e-3
    """Rate at which an object in view ceases to exist, 1/s."""


class LifeSettings(Settings, frozen=True):
    """Changes of an object's state [SSIE figure 5]."""

    confirm_echoes: Annotated[int, msgspec.Meta(ge=2), slider(2, 10)] = 3
    """Needed before a new object is reported."""
    confirm_existence: Annotated[Probability, slider(0.5, 0.99, step=0.01)] = 0.99
    """Needed before a new object is reported. More: fewer false obstacles, later confirmation."""
    drop_existence: Annotated[Probability, slider(0.05, 0.95, step=0.01)] = 0.4
    """A reported object whose existence falls below this is dropped."""
    edge_sigmas: Annotated[NonNegative, slider(0.0, 5.0, step=0.1)] = 2.0
    """A missed detection counts only if the prediction lies this far inside the sector."""
    silent_s: Annotated[Positive, slider(0.5, 30.0, step=0.5, unit="s")] = 3.0
    """An object in view without an echo for this long goes to stand-by."""
    stand_by_s: Annotated[Positive, slider(1.0, 120.0, step=1.0, unit="s")] = 10.0
    """An object out of view without an echo for this long is hibernated (static) or terminated (moving)."""
    lost_sigma_m: Annotated[Positive, slider(0.5, 20.0, step=0.5, unit="m")] = 4.0
    """Position sigma beyond which an unobserved object goes to stand-by, and one on stand-by ends."""


class PlannerSettings(Settings, frozen=True):
    """The obstacle list to the path planner."""

    period_s: Annotated[float, msgspec.Meta(gt=0.0, le=0.5), slider(0.05, 0.5, step=0.05, unit="s")] = 0.4
    """Between lists while no detections arrive."""
    announce_ended: Annotated[PositiveInt, slider(1, 20, unit="lists")] = 5
    """Lists in a row that report an ended object as `terminated`."""
    most_listed: Annotated[PositiveInt, slider(10, 2000, step=10)] = 1000
    """The nearest."""
    shape_sigma: Annotated[NonNegative, slider(0.0, 1.0, step=0.05)] = 0.2
    """Of horizontal position and radius, in radii, whatever the number of echoes: only the near side is visible."""
    hibernated_within_m: Annotated[NonNegative, slider(0.0, 500.0, step=10.0, unit="m")] = 150.0
    """Hibernated objects this near the vehicle are listed."""
    lead_times_s: Annotated[
        tuple[Annotated[NonNegative, slider(0.0, 120.0, unit="s")], ...], msgspec.Meta(max_length=20)
    ] = (5.0, 10.0, 20.0)
    """Times ahead for which positions are predicted."""
    approach_horizon_s: Annotated[Positive, slider(10.0, 600.0, step=10.0, unit="s")] = 300.0
    """For closest points of approach."""


class BottomSettings(Settings, frozen=True):
    """Objects on the bottom, if the vehicle's altitude is known."""

    clearance_m: Annotated[Positive, slider(0.1, 10.0, log=True, unit="m")] = 1.0
    """An object that rises higher above the bottom is an obstacle."""
    list: Literal["hittable", "all"] = "hittable"
    """hittable: objects that rise no higher are omitted, if certain enough (`risk`); all: none is omitted."""
    risk: Annotated[Probability, slider(0.001, 0.1, log=True)] = 0.01
    """Highest probability that an omitted object rises higher."""
    slope_deg: Annotated[float, msgspec.Meta(ge=0.0, le=45.0), slider(0.0, 45.0, step=0.5, unit="deg")] = 5.0
    """Sigma of the bottom's mean slope from vehicle to object."""
    roughness_m: Annotated[NonNegative, slider(0.0, 2.0, step=0.05, unit="m")] = 0.2
    """Sigma of the bottom's height about that slope."""


class SurfaceSettings(Settings, frozen=True):
    """Waves, where the fan meets the surface."""

    down_m: float = 0.0
    """Down coordinate of the surface; 0: the site's heights count from the surface."""
    list: Literal["hittable", "all"] = "hittable"
    """hittable: objects that move as waves do, at one velocity and where the surface may be, are left out; all: none
    is."""
    clearance_m: Annotated[Positive, slider(0.1, 10.0, log=True, unit="m")] = 1.0
    """An object known to be deeper below the surface is not a wave."""


class ClearanceSettings(Settings, frozen=True):
    """The message `clearance`: water known to be empty."""

    sectors: Annotated[int, msgspec.Meta(ge=8, le=360), slider(8, 360)] = 72
    """Clockwise from north."""
    half_height_m: Annotated[NonNegative, slider(0.1, 5.0, log=True, unit="m")] = 0.3
    """Half height of the layer that the fan must cover, above and below the vehicle's origin."""
    fastest_m_s: Annotated[Positive, slider(0.1, 10.0, log=True, unit="m/s")] = 2.0
    """Largest horizontal speed of unobserved objects."""
    fastest_vertical_m_s: Annotated[Positive, slider(0.05, 5.0, log=True, unit="m/s")] = 0.5
    """Largest vertical speed of unobserved objects."""


class MapSettings(Settings, frozen=True):
    """The store of hibernated objects."""

    path: Path | None = None
    """SQLite file; none: the map is lost when the process ends."""
    position_sigma_m: Annotated[NonNegative, slider(0.0, 5.0, step=0.1, unit="m")] = 0.5
    """Pose error between missions, added to north and east of objects of an earlier mission."""
    minimum_times_seen: Annotated[NonNegativeInt, slider(0, 50)] = 5
    """Objects with fewer echoes are not stored for the next mission."""


class TrackerSettings(Settings, frozen=True):
    """Detections and poses to obstacles."""

    plugins: tuple[Path, ...] = ()
    """Python files or modules."""
    observer: str = "manoeuvring"
    """The filters of an object's state."""
    association: str = "probabilistic"
    """Of echoes: `nearest` (one each, largest sum of scores) or `probabilistic` (all possible ones, weighted)."""
    motion: MotionSettings = MotionSettings()
    echo: EchoSettings = EchoSettings()
    life: LifeSettings = LifeSettings()
    planner: PlannerSettings = PlannerSettings()
    bottom: BottomSettings = BottomSettings()
    surface: SurfaceSettings = SurfaceSettings()
    clearance: ClearanceSettings = ClearanceSettings()
    map: MapSettings = MapSettings()
    resume_within_s: Annotated[NonNegativeSeconds, slider(0.0, 60.0, step=1.0, unit="s")] = 10.0
    """A tracker restarted within this time keeps its objects; 0: never."""

    def __post_init__(self) -> None:
        for key, name, known in (
            ("observer", self.observer, OBSERVER_NAMES),
            ("association", self.association, ASSOCIATION_NAMES),
        ):
            if name not in known and not PLUGINS.may_add(self.plugins):
                raise ValueError(f"{key}: {none_of(name, known)}")
        if self.life.drop_existence >= self.life.confirm_existence:
            raise ValueError("life.drop_existence: must be below life.confirm_existence")


class TrackerConfig(Settings, frozen=True):
    """The part of the configuration that makes a tracker what it is."""

    site: SiteSettings
    pose: PoseSettings
    tracker: TrackerSettings
    mounting: MountingSettings = MountingSettings()
    """`[sonar.mounting]`."""


class TrackerProcessConfig(TrackerConfig, frozen=True):
    """The part of the configuration that the tracker process reads."""

    bus: BusSettings = msgspec.field(default_factory=BusSettings)
    """For the keys of operators."""
