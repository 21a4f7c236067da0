"""A scene changed: objects put in and taken out, way-points of its paths."""

from collections.abc import Callable
from typing import Any

from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.model.actions import Place
from ods.workbench.model.paths import PathError, typed, value_at, with_tables

SHAPES: dict[str, dict[str, Any]] = {
    "sphere": {"radius_m": 1.0},
    "cylinder": {"radius_m": 0.5, "length_m": 3.0},
    "plane": {"normal_ned": [1.0, 0.0, 0.0], "width_m": 10.0, "height_m": 4.0},
}
"""What a new object of each shape is like."""


NEW: dict[str, Any] = {
    "seed": 1,
    "duration_s": 60.0,
    "vehicle": {"position_ned": [0.0, 0.0, 10.0], "velocity_ned": [0.5, 0.0, 0.0]},
    "sea_bed": {"depth_m": 20.0},
    "image": {"gain": 20000.0, "noise_counts": 30.0},
}
"""A scene to begin with: nothing in it, 10 m over the sea-bed."""


def with_object(scene: SceneFile, shape: str, position_ned: Place) -> SceneFile:
    """Put an object at a place, at rest, under a name of its own. Raises PathError."""
    name = _free_name(scene, shape, 1)
    new = {"shape": shape, "name": name, "position_ned": list(position_ned), **SHAPES[shape]}
    return with_tables(scene, "objects", lambda objects: [*objects, new])


def with_copy(scene: SceneFile, at: int, moved_ned: Place) -> SceneFile:
    """Put an object like another into the scene, elsewhere, under a name of its own. Raises PathError."""
    _check_object(scene, at)
    name = _free_name(scene, scene.objects[at].name, 2)

    def moved(place: list[float]) -> list[float]:
        return [round(value + by, 3) for value, by in zip(place, moved_ned, strict=True)]

    def change(objects: list[dict[str, Any]]) -> list[dict[str, Any]]:
        new = objects[at] | {"name": name}
        if new["position_ned"] is not None:
            new["position_ned"] = moved(new["position_ned"])
        new["waypoints"] = [point | {"position_ned": moved(point["position_ned"])} for point in new["waypoints"]]
        return [*objects, new]

    return with_tables(scene, "objects", change)


def _free_name(scene: SceneFile, of: str, first: int) -> str:
    names = {item.name for item in scene.objects}
    return next(name for number in range(first, len(names) + 3) if (name := f"{of} {number}") not in names)


def _check_object(scene: SceneFile, at: int) -> None:
    if not 0 <= at < len(scene.objects):
        raise PathError(f"objects[{at}]: no such object")


def without_object(scene: SceneFile, at: int) -> SceneFile:
    """Take an object out. Raises PathError."""
    _check_object(scene, at)
    return with_tables(scene, "objects", lambda objects: objects[:at] + objects[at + 1 :])


def with_waypoint(scene: SceneFile, of: str, t_s: float, position_ned: Place) -> SceneFile:
    """Put a way-point into a path, in order of time, instead of one of the same time. Raises PathError."""

    def change(path: dict[str, Any]) -> dict[str, Any]:
        points = [point for point in _curve(path, scene.duration_s) if point["t_s"] != t_s]
        points = sorted([*points, {"t_s": t_s, "position_ned": list(position_ned)}], key=lambda point: point["t_s"])
        return path | {"position_ned": None, "velocity_ned": [0.0, 0.0, 0.0], "waypoints": points}

    return _with_path(scene, of, change)


def without_waypoint(scene: SceneFile, of: str, at: int) -> SceneFile:
    """Take a way-point out of a path. Raises PathError."""

    def change(path: dict[str, Any]) -> dict[str, Any]:
        points = list(path["waypoints"])
        if not 0 <= at < len(points):
            raise PathError(f"{of}.waypoints[{at}]: no such way-point")
        del points[at]
        return path | {"waypoints": points}

    return _with_path(scene, of, change)


def _with_path(scene: SceneFile, of: str, change: Callable[[dict[str, Any]], dict[str, Any]]) -> SceneFile:
    path = value_at(scene, of)
    if not isinstance(path, dict) or "waypoints" not in path:
        raise PathError(f"{of}: has no path")
    return with_tables(scene, of, change)


def _curve(path: dict[str, Any], duration_s: float) -> list[dict[str, Any]]:
    """Return the way-points of a path; of a straight one where it begins and where it ends."""
    if path["waypoints"]:
        return list(path["waypoints"])
    begin, velocity = path["position_ned"], path["velocity_ned"]
    end = [place + duration_s * speed for place, speed in zip(begin, velocity, strict=True)]
    return [{"t_s": 0.0, "position_ned": begin}, {"t_s": duration_s, "position_ned": end}]


def scene_of(tables: dict[str, Any]) -> SceneFile:
    """Return a scene of its file's tables. Raises PathError."""
    return typed(tables, SceneFile)
