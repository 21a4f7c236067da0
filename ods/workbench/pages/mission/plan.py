"""A tracked mission as a plan [SSIE figure 6]: what is there all the time, and what is known at one ping."""

import math
from collections.abc import Callable

import numpy as np

from ods.base.arrays import Floats
from ods.messages import Obstacle, ObstacleList
from ods.tracker.output.obstacle_list import NAMES
from ods.workbench.engine.mission.tracked import Course, Tracked, track_name
from ods.workbench.web.views.plan_view import Area, Circle, Ellipse, Line, Mark, Place, Role, Shape

MOST_POINTS = 400
"""Of a line."""
SIGMAS = 2.0
"""Half width of ellipses and bands, standard deviations."""
ROLES: dict[int, Role] = {0: "tentative", **NAMES}
"""Of the states of `lifecycle`."""


def ways(result: Tracked) -> list[Shape]:
    """Return the ways of vehicle, true objects and tracked ones, these in the colours of their states."""
    shapes: list[Shape] = [Line(points_of(truth.position), "truth", truth.name) for truth in result.truths]
    for course in result.courses:
        shapes += _trail(course)
    shapes.append(Line(points_of(result.path), "vehicle"))
    return shapes


def points_of(position: Floats) -> list[Place]:
    """Return places, (n, 2 or 3) NED, as points of a line; of many of them evenly some."""
    chosen = np.unique(np.linspace(0, len(position) - 1, min(len(position), MOST_POINTS)).astype(np.int64))
    return [(round(north, 3), round(east, 3)) for north, east in position[chosen, :2].tolist()]


def _trail(course: Course) -> list[Line]:
    lines = []
    for span in course.lives():
        rows = (course.t_s >= span.from_s) & (course.t_s <= span.to_s)
        if np.count_nonzero(rows) > 1 and span.state in NAMES and NAMES[span.state] != "terminated":
            lines.append(Line(points_of(course.position[rows]), NAMES[span.state]))
    return lines


def moment(result: Tracked, place: int, marked: int | None) -> list[Shape]:
    """Return what is known at a ping: vehicle, sector, objects, their ellipses, predictions and closest approach."""
    if not 0 <= place < len(result.t_s):
        return []
    shapes: list[Shape] = []
    outline = result.outline(place)
    if len(outline):
        shapes.append(Area(points_of(outline), "sector"))
    latest = result.list_at(place)
    shapes += _true_objects(result, place)
    if latest is not None:
        shapes += objects(latest, marked, result.name_of)
        shapes += approach(latest, marked, result.path[place], velocity_at(result, place), result.name_of)
    shapes.append(Mark(flat(result.path[place]), "vehicle", round(result.heading(place), 4)))
    return shapes


def _true_objects(result: Tracked, place: int) -> list[Shape]:
    t_s = result.t_s[place]
    found: list[Shape] = []
    for truth in result.truths:
        rows = np.flatnonzero(np.abs(truth.t_s - t_s) < 1e-6)
        if len(rows):
            found.append(Circle(flat(truth.position[rows[0]]), truth.radius_m, "truth"))
    return found


def objects(latest: ObstacleList, marked: int | None, name_of: Callable[[int], str] = track_name) -> list[Shape]:
    """Return the objects of a list with their ellipses and predictions; name_of: what a track is called."""
    shown = [item for item in latest.obstacles if item.state != "terminated"]
    return [shape for item in shown for shape in _object(item, marked, name_of(item.id))]


def _object(obstacle: Obstacle, marked: int | None, name: str) -> list[Shape]:
    is_marked = obstacle.id == marked
    at = flat(obstacle.position_ned)
    speed = math.hypot(*obstacle.velocity_ned[:2])
    label = f"{name}: r {obstacle.radius_m:.1f} m, {speed:.1f} m/s" + (", ignored" if obstacle.ignored_by >= 0 else "")
    shapes: list[Shape] = [
        ellipse_of(at, obstacle.sigma_position[0], obstacle.sigma_position[1], obstacle.covariance_ne),
        Circle(at, round(obstacle.radius_m, 3), obstacle.state, label, str(obstacle.id), marked=is_marked),
    ]
    if speed > 0.0 and (is_marked or obstacle.state == "active"):
        shapes.append(Line([at, *(flat(each.position_ned) for each in obstacle.predicted)], "prediction"))
    for each in obstacle.predicted if is_marked else ():
        north, east, _ = (round(SIGMAS * sigma, 3) for sigma in each.sigma_position)
        shapes.append(Ellipse(flat(each.position_ned), (north, east), 0.0, "prediction"))
        shapes.append(Mark(flat(each.position_ned), "prediction", label=f"in {each.lead_s:g} s"))
    return shapes


def ellipse_of(at: Place, sigma_north: float, sigma_east: float, covariance: float) -> Ellipse:
    """Return the error ellipse of a place, m, of SIGMAS standard deviations."""
    square = np.array([[sigma_north**2, covariance], [covariance, sigma_east**2]])
    values, vectors = np.linalg.eigh(square)
    minor, major = (SIGMAS * math.sqrt(max(0.0, value)) for value in values.tolist())
    north, east = vectors[:, 1].tolist()
    return Ellipse(at, (round(major, 3), round(minor, 3)), round(math.atan2(east, north), 4))


def approach(
    latest: ObstacleList, marked: int | None, at: Floats, velocity: Floats, name_of: Callable[[int], str] = track_name
) -> list[Shape]:
    """Return the closest approach to the vehicle of the marked object, or of the one that comes nearest.

    at, velocity: the vehicle's, (3,) NED, m and m/s.
    """
    coming = [(item.cpa, item) for item in latest.obstacles if item.cpa is not None and item.cpa.time_s > 0.0]
    nearest = sorted(coming, key=lambda pair: (pair[1].id != marked, pair[0].distance_m))[:1]
    shapes: list[Shape] = []
    for cpa, item in nearest:
        after_s = cpa.time_s
        vehicle = at + after_s * velocity
        there = np.array(item.position_ned) + after_s * np.array(item.velocity_ned)
        label = f"nearest to {name_of(item.id)}: {cpa.distance_m:.1f} ± {cpa.sigma_m:.1f} m in {after_s:.0f} s"
        shapes.append(Line([flat(there), flat(vehicle)], "approach", label))
    return shapes


def velocity_at(result: Tracked, place: int) -> Floats:
    """Return the vehicle's velocity at a ping, (3,) NED m/s, from its places."""
    if len(result.t_s) < 2:
        return np.zeros(3)
    first = min(max(0, place - 1), len(result.t_s) - 2)
    spent_s = result.t_s[first + 1] - result.t_s[first]
    step: Floats = result.path[first + 1] - result.path[first]
    return step / spent_s if spent_s > 0.0 else np.zeros(3)


def flat(position: Floats | tuple[float, float, float]) -> Place:
    """Return north and east of a position, m."""
    return round(float(position[0]), 3), round(float(position[1]), 3)
