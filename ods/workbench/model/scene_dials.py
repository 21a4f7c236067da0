"""Which sliders a scene's parts get, and how far they go; a value beyond can be typed."""

from typing import NamedTuple

from ods.sim_sonar.scene.settings import Cylinder, Plane, SceneFile, Sphere
from ods.sim_sonar.scene.settings import Path as MovingPath


class Dial(NamedTuple):
    """A slider."""

    label: str
    path: str
    """In SceneFile."""
    low: float
    high: float
    step: float
    unit: str = ""


class Group(NamedTuple):
    """Sliders that belong together."""

    title: str
    dials: list[Dial]


def object_groups(scene: SceneFile, place: int) -> list[Group]:
    """Return the sliders of an object."""
    item, of = scene.objects[place], f"objects[{place}]"
    return [
        Group("Shape", _shape(item, of)),
        Group("Path", _path(item, of)),
        Group("Surface", _surface(f"{of}.surface")),
    ]


def vehicle_groups(scene: SceneFile) -> list[Group]:
    """Return the sliders of the vehicle: its path, and roll, pitch and yaw as sines."""
    path = [*_path(scene.vehicle, "vehicle"), Dial("heading", "vehicle.heading_deg", -180.0, 180.0, 1.0, "°")]
    return [Group("Path", path), *(_swing(name) for name in ("roll", "pitch", "yaw"))]


def sea_bed_groups(scene: SceneFile) -> list[Group]:
    """Return the sliders of the sea-bed; none without one."""
    if scene.sea_bed is None:
        return []
    plane = [
        Dial("depth", "sea_bed.depth_m", 1.0, 100.0, 0.1, "m"),
        Dial("slope", "sea_bed.slope_deg", 0.0, 30.0, 0.1, "°"),
        Dial("falls towards", "sea_bed.slope_heading_deg", -180.0, 180.0, 1.0, "°"),
    ]
    groups = [Group("Plane", plane), Group("Surface", _surface("sea_bed.surface"))]
    if scene.sea_bed.rough is not None:
        rough = [
            Dial("height, rms", "sea_bed.rough.rms_height_m", 0.0, 1.0, 0.01, "m"),
            Dial("correlation", "sea_bed.rough.correlation_m", 0.5, 20.0, 0.1, "m"),
        ]
        groups.append(Group("Roughness", rough))
    return groups


def image_groups() -> list[Group]:
    """Return the sliders of the levels."""
    levels = [
        Dial("gain", "image.gain", 1000.0, 100_000.0, 500.0, "counts/m²"),
        Dial("noise", "image.noise_counts", 0.0, 500.0, 1.0, "counts"),
        Dial("looks", "image.looks", 0.5, 20.0, 0.5),
        Dial("coherence", "image.coherence_s", 0.0, 10.0, 0.1, "s"),
    ]
    return [Group("Levels", levels)]


def _surface(of: str) -> list[Dial]:
    return [
        Dial("diffuse Cd", f"{of}.cd", 0.0, 1.0, 0.01),
        Dial("specular Cs", f"{of}.cs", 0.0, 1.0, 0.01),
        Dial("roughness", f"{of}.sigma_deg", 1.0, 90.0, 0.5, "°"),
    ]


def _shape(item: Sphere | Cylinder | Plane, of: str) -> list[Dial]:
    if isinstance(item, Plane):
        dials = _triple("normal", f"{of}.normal_ned", -1.0, 1.0, "")
        if item.width_m is not None:
            dials += [_size("width", f"{of}.width_m"), _size("height", f"{of}.height_m")]
        return dials
    dials = [Dial("radius", f"{of}.radius_m", 0.1, 10.0, 0.05, "m")]
    if isinstance(item, Cylinder):
        dials += [_size("length", f"{of}.length_m"), *_triple("axis", f"{of}.axis_ned", -1.0, 1.0, "")]
    return dials


def _size(label: str, path: str) -> Dial:
    return Dial(label, path, 0.1, 50.0, 0.1, "m")


def _path(moving: MovingPath, of: str) -> list[Dial]:
    """Return the sliders of a straight path; way-points are dragged, and typed in a table."""
    if moving.waypoints:
        return []
    return [
        Dial("depth", f"{of}.position_ned[2]", 0.0, 100.0, 0.1, "m"),
        *_triple("velocity", f"{of}.velocity_ned", -3.0, 3.0, "m/s"),
    ]


def _triple(label: str, path: str, low: float, high: float, unit: str) -> list[Dial]:
    axes = ("north", "east", "down")
    return [Dial(f"{label} {axis}", f"{path}[{place}]", low, high, 0.05, unit) for place, axis in enumerate(axes)]


def _swing(name: str) -> Group:
    of = f"vehicle.{name}"
    return Group(
        name.capitalize(),
        [
            Dial("amplitude", f"{of}.amplitude_deg", 0.0, 30.0, 0.1, "°"),
            Dial("period", f"{of}.period_s", 1.0, 60.0, 0.5, "s"),
            Dial("phase", f"{of}.phase_deg", -180.0, 180.0, 5.0, "°"),
        ],
    )
