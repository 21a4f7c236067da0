"""Which sliders a scene's parts get, and how far they go; a value beyond can be typed."""

from typing import NamedTuple

from ods.sim_sonar.scene.settings import Cylinder, Path as MovingPath, Plane, SceneFile, Sphere
from ods.workbench.model.sliders import Control, Number


class Group(NamedTuple):
    """Sliders that belong together."""

    title: str
    dials: list[Control]
    """Their paths are those in SceneFile."""


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
    path = [*_path(scene.vehicle, "vehicle"), _dial("heading", "vehicle.heading_deg", -180.0, 180.0, 1.0, "°")]
    return [Group("Path", path), *(_swing(name) for name in ("roll", "pitch", "yaw"))]


def sea_bed_groups(scene: SceneFile) -> list[Group]:
    """Return the sliders of the sea-bed; none without one."""
    if scene.sea_bed is None:
        return []
    plane = [
        _dial("depth", "sea_bed.depth_m", 1.0, 100.0, 0.1, "m"),
        _dial("slope", "sea_bed.slope_deg", 0.0, 30.0, 0.1, "°"),
        _dial("falls towards", "sea_bed.slope_heading_deg", -180.0, 180.0, 1.0, "°"),
    ]
    groups = [Group("Plane", plane), Group("Surface", _surface("sea_bed.surface"))]
    if scene.sea_bed.rough is not None:
        rough = [
            _dial("height, rms", "sea_bed.rough.rms_height_m", 0.0, 1.0, 0.01, "m"),
            _dial("correlation", "sea_bed.rough.correlation_m", 0.5, 20.0, 0.1, "m"),
        ]
        groups.append(Group("Roughness", rough))
    return groups


def image_groups() -> list[Group]:
    """Return the sliders of the levels."""
    levels = [
        _dial("gain", "image.gain", 1000.0, 100_000.0, 500.0, "counts/m²"),
        _dial("noise", "image.noise_counts", 0.0, 500.0, 1.0, "counts"),
        _dial("looks", "image.looks", 0.5, 20.0, 0.5),
        _dial("coherence", "image.coherence_s", 0.0, 10.0, 0.1, "s"),
    ]
    return [Group("Levels", levels)]


def _dial(label: str, path: str, low: float, high: float, step: float, unit: str = "") -> Control:
    return Control(path, Number(low, high, step, unit=unit), low, label=label)


def _surface(of: str) -> list[Control]:
    return [
        _dial("diffuse Cd", f"{of}.cd", 0.0, 1.0, 0.01),
        _dial("specular Cs", f"{of}.cs", 0.0, 1.0, 0.01),
        _dial("roughness", f"{of}.sigma_deg", 1.0, 90.0, 0.5, "°"),
    ]


def _shape(item: Sphere | Cylinder | Plane, of: str) -> list[Control]:
    if isinstance(item, Plane):
        dials = _triple("normal", f"{of}.normal_ned", -1.0, 1.0, "")
        if item.width_m is not None:
            dials += [_size("width", f"{of}.width_m"), _size("height", f"{of}.height_m")]
        return dials
    dials = [_dial("radius", f"{of}.radius_m", 0.1, 10.0, 0.05, "m")]
    if isinstance(item, Cylinder):
        dials += [_size("length", f"{of}.length_m"), *_triple("axis", f"{of}.axis_ned", -1.0, 1.0, "")]
    return dials


def _size(label: str, path: str) -> Control:
    return _dial(label, path, 0.1, 50.0, 0.1, "m")


def _path(moving: MovingPath, of: str) -> list[Control]:
    """Return the sliders of a straight path; way-points are dragged, and typed in a table."""
    if moving.waypoints:
        return []
    return [
        _dial("north", f"{of}.position_ned[0]", -100.0, 100.0, 0.1, "m"),
        _dial("east", f"{of}.position_ned[1]", -100.0, 100.0, 0.1, "m"),
        _dial("depth", f"{of}.position_ned[2]", 0.0, 100.0, 0.1, "m"),
        *_triple("velocity", f"{of}.velocity_ned", -3.0, 3.0, "m/s"),
    ]


def _triple(label: str, path: str, low: float, high: float, unit: str) -> list[Control]:
    axes = ("north", "east", "down")
    return [_dial(f"{label} {axis}", f"{path}[{place}]", low, high, 0.05, unit) for place, axis in enumerate(axes)]


def _swing(name: str) -> Group:
    of = f"vehicle.{name}"
    return Group(
        name.capitalize(),
        [
            _dial("amplitude", f"{of}.amplitude_deg", 0.0, 30.0, 0.1, "°"),
            _dial("period", f"{of}.period_s", 1.0, 60.0, 0.5, "s"),
            _dial("phase", f"{of}.phase_deg", -180.0, 180.0, 5.0, "°"),
        ],
    )
