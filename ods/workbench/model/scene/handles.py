"""What can be dragged in the plan of a scene, and what a drag sets. The plan: north and east, m."""

import math
from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

from ods.sim_sonar.scene.motion import Motion
from ods.sim_sonar.scene.settings import Cylinder, Path as MovingPath, Plane, SceneFile, Sphere, Triple
from ods.workbench.model.actions import SetScene
from ods.workbench.model.paths import PathError, value_at

ARM_M = 4.0
"""From a plane's centre to the handle that turns it, m."""
SHORTEST_M = 0.05
"""Least size that a drag makes, m."""
Spot = tuple[float, float]
Kind = Literal["place", "waypoint", "size", "turn"]


class Handle(NamedTuple):
    """Something to drag."""

    path: str
    """Of what it sets, in SceneFile; for a place that follows way-points, that of the way-points."""
    kind: Kind
    at: Spot
    """North and east, m."""


def handles_of(scene: SceneFile, t_s: float) -> list[Handle]:
    """Return all handles, with everything where it is at scene time `t_s`."""
    found = list(_of_path(scene.vehicle, "vehicle", t_s))
    for place, item in enumerate(scene.objects):
        of = f"objects[{place}]"
        found += [*_of_path(item, of, t_s), *(Handle(*each) for each in _of_shape(item, of, t_s))]
    return found


def snapped(value: float, step: float) -> float:
    """Return the nearest multiple of a step; without one (0) the value to a millimetre."""
    return round(round(value / step) * step if step else value, 3)


def dragged(scene: SceneFile, path: str, to: Spot, t_s: float, step_m: float = 0.0) -> SetScene:
    """Return the action that brings the handle of `path` to a place at scene time `t_s`. Raises PathError.

    step_m: places and sizes are multiples of it, directions are rounded.
    """
    action = _dragged(scene, path, (snapped(to[0], step_m), snapped(to[1], step_m)), t_s)
    if isinstance(action.value, float):
        return SetScene(path, max(step_m, SHORTEST_M, snapped(action.value, step_m)))
    return action


def _dragged(scene: SceneFile, path: str, to: Spot, t_s: float) -> SetScene:
    of, _, what = path.partition(".")
    moving = _moving(scene, of)
    if what == "position_ned":
        start, shift = value_at(scene, path), _shift(moving, to, t_s)
        return SetScene(path, _moved(start, shift))
    if what == "waypoints":
        shift = _shift(moving, to, t_s)
        points = value_at(scene, path)
        return SetScene(path, [point | {"position_ned": _moved(point["position_ned"], shift)} for point in points])
    if what.startswith("waypoints["):
        down = value_at(scene, path)[2]
        return SetScene(path, [*to, down])
    centre = _at(moving, t_s)
    away = (to[0] - centre[0], to[1] - centre[1])
    if what in _SIZES:
        return SetScene(path, max(SHORTEST_M, _SIZES[what](value_at(scene, of), away)))
    if what in _TURNS:
        return SetScene(path, _turned(value_at(scene, path), away))
    raise PathError(f"{path}: cannot be dragged")


def place_at(scene: SceneFile, of: str, t_s: float) -> Triple:
    """Return where the vehicle ("vehicle") or an object ("objects[2]") is: north, east, down, m. Raises PathError."""
    return _at(_moving(scene, of), t_s)


def _moving(scene: SceneFile, of: str) -> MovingPath:
    for name, moving in [("vehicle", scene.vehicle), *((f"objects[{i}]", x) for i, x in enumerate(scene.objects))]:
        if name == of:
            return moving
    raise PathError(f"{of}: no such object")


def _of_path(moving: MovingPath, of: str, t_s: float) -> Iterator[Handle]:
    north, east, _ = _at(moving, t_s)
    yield Handle(f"{of}.{'waypoints' if moving.waypoints else 'position_ned'}", "place", (north, east))
    for number, point in enumerate(moving.waypoints):
        yield Handle(f"{of}.waypoints[{number}].position_ned", "waypoint", point.position_ned[:2])


def _of_shape(item: Sphere | Cylinder | Plane, of: str, t_s: float) -> Iterator[tuple[str, Kind, Spot]]:
    north, east, _ = _at(item, t_s)

    def spot(direction: Spot, distance: float) -> Spot:
        return north + distance * direction[0], east + distance * direction[1]

    if isinstance(item, Sphere):
        yield f"{of}.radius_m", "size", spot((0.0, 1.0), item.radius_m)
    elif isinstance(item, Cylinder):
        along, share = _level(item.axis_ned)
        yield f"{of}.radius_m", "size", spot((-along[1], along[0]), item.radius_m)
        if share > 0.0:
            yield f"{of}.length_m", "size", spot(along, -0.5 * item.length_m * share)
            yield f"{of}.axis_ned", "turn", spot(along, 0.5 * item.length_m * share + ARM_M)
    else:
        along, share = _level(item.normal_ned)
        if share > 0.0:
            yield f"{of}.normal_ned", "turn", spot(along, ARM_M)
        if item.width_m is not None:
            yield f"{of}.width_m", "size", spot(_side(along, share), 0.5 * item.width_m)


def _at(moving: MovingPath, t_s: float) -> Triple:
    north, east, down = Motion(moving).position(t_s).tolist()
    return north, east, down


def _shift(moving: MovingPath, to: Spot, t_s: float) -> Spot:
    north, east, _ = _at(moving, t_s)
    return to[0] - north, to[1] - east


def _moved(place: list[float], shift: Spot) -> list[float]:
    return [round(place[0] + shift[0], 3), round(place[1] + shift[1], 3), place[2]]


def _level(direction: Triple) -> tuple[Spot, float]:
    """Return the heading of a direction as a unit vector, north where it is vertical, and its level share."""
    level, whole = math.hypot(*direction[:2]), math.hypot(*direction)
    if level < 1e-6 * whole:
        return (1.0, 0.0), 0.0
    return (direction[0] / level, direction[1] / level), level / whole


def _side(along: Spot, share: float) -> Spot:
    """Return where a plane's horizontal side runs: the northern one where its normal is vertical."""
    return (-along[1], along[0]) if share > 0.0 else (1.0, 0.0)


def _turned(direction: list[float], towards: Spot) -> list[float]:
    """Turn a direction about the vertical."""
    level, distance = math.hypot(*direction[:2]), math.hypot(*towards)
    if distance < 1e-6:
        return direction
    return [round(level * towards[0] / distance, 4), round(level * towards[1] / distance, 4), direction[2]]


def _length(item: dict[str, list[float]], away: Spot) -> float:
    north, east, down = item["axis_ned"]
    share = _level((north, east, down))[1]
    return 2.0 * math.hypot(*away) / (share or 1.0)


_SIZES: dict[str, Callable[[dict[str, list[float]], Spot], float]] = {
    "radius_m": lambda _, away: math.hypot(*away),
    "width_m": lambda _, away: 2.0 * math.hypot(*away),
    "length_m": _length,
}
_TURNS = ("axis_ned", "normal_ned")
