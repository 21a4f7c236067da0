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


def with_object(scene: SceneFile, shape: str, position_ned: Place) -> SceneFile:
    """Put an object at a place, at rest, under a name of its own. Raises PathError."""
    names = {item.name for item in scene.objects}
    name = next(name for number in range(1, len(names) + 2) if (name := f"{shape} {number}") not in names)
    new = {"shape": shape, "name": name, "position_ned": list(position_ned), **SHAPES[shape]}
    return with_tables(scene, "objects", lambda objects: [*objects, new])


def without_object(scene: SceneFile, at: int) -> SceneFile:
    """Take an object out. Raises PathError."""
    if not 0 <= at < len(scene.objects):
        raise PathError(f"objects[{at}]: no such object")
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
