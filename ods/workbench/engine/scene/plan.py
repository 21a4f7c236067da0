"""A scene seen from above: outlines and paths. The plan: (n, 2) north and east, m."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.sim_sonar.echo.bodies.bodies import PLANE, SPHERE, Bodies
from ods.sim_sonar.scene.motion import Motion
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.model import SonarModel
from ods.workbench.engine.scene.curves import Curve

ROUND = np.linspace(0.0, 2.0 * np.pi, 49)
LONGEST_M = 200.0
"""Half of a wall that has no bounds, as far as it is drawn, m."""
PATH_POINTS = 121


class Outline(NamedTuple):
    """An object from above."""

    name: str
    edge: Floats
    """(n, 2) closed."""


class Plan(NamedTuple):
    """A scene at one time."""

    outlines: list[Outline]
    """In the order of the scene's objects."""
    paths: dict[str, Floats]
    """Of the vehicle and of all that moves, by "vehicle" and "objects[2]": (n, 2)."""
    sector: Floats
    """(n, 2) what the sonar insonifies, closed."""
    vehicle: tuple[float, float, float]
    """North, east, m; heading of the sonar's head, rad."""


def plan_of(scene: Scene, sonar: SonarModel, t_s: float) -> Plan:
    """Return a scene as it is at scene time `t_s`, with the paths of the whole of it."""
    times = np.linspace(0.0, scene.file.duration_s, PATH_POINTS)
    paths = {"vehicle": scene.pose_at(times).position_ned[:, :2]}
    ways = np.stack([scene.bodies_at(float(t))["centre"][:, :2] for t in times])
    for place in range(ways.shape[1]):
        if np.ptp(ways[:, place], axis=0).max() > 0.0:
            paths[f"objects[{place}]"] = ways[:, place]
    bodies = scene.bodies_at(t_s)
    outlines = [Outline(item.name, _edge(bodies, place)) for place, item in enumerate(scene.file.objects)]
    head = scene.head_at(t_s)
    bearing = np.linspace(sonar.bearing_rad.min(), sonar.bearing_rad.max(), 61)
    arc = geometry.polar_to_body(sonar.range_max_m, bearing)
    edge = geometry.body_to_global(np.vstack([np.zeros((1, 3)), arc, np.zeros((1, 3))]), *head)
    bow = geometry.body_to_global(np.array([1.0, 0.0, 0.0]), *head) - head.position_ned
    north, east = head.position_ned[:2].tolist()
    return Plan(outlines, paths, edge[:, :2], (north, east, float(np.arctan2(bow[1], bow[0]))))


def strip_of(file: SceneFile, of: str) -> list[Curve]:
    """Return depth, m, and speed over ground, m/s, of a path over scene time, s; `of`: "vehicle" or "objects[2]"."""
    moving = Motion(file.vehicle if of == "vehicle" else file.objects[int(of[len("objects[") : -1])])
    times = np.linspace(0.0, file.duration_s, PATH_POINTS)
    speed = np.linalg.norm(moving.velocity(times), axis=-1)
    return [Curve(times, moving.position(times)[:, 2]), Curve(times, np.asarray(speed, np.float64))]


def _edge(bodies: Bodies, place: int) -> Floats:
    """Return the outline of a body: the hull of its edges seen from above."""
    body = bodies[place]
    centre, axes = np.array(body["centre"]), np.array(body["axes"])
    x, y, z = np.minimum(body["half"], LONGEST_M)
    circle = np.stack([np.cos(ROUND), np.sin(ROUND)], axis=-1)
    if body["kind"] == SPHERE:
        return np.asarray(centre[:2] + x * circle)
    if body["kind"] == PLANE:
        corners = np.array([(x, y, 0.0), (-x, y, 0.0), (-x, -y, 0.0), (x, -y, 0.0)])
    else:
        corners = np.vstack([np.column_stack([x * circle, np.full(len(circle), end)]) for end in (z, -z)])
    return _hull((centre + corners @ axes)[:, :2])


def _hull(points: Floats) -> Floats:
    """Return the closed hull of points in the plane; of points on a line, the line."""
    spread = points - points.mean(axis=0)
    if np.linalg.matrix_rank(spread, tol=1e-6 * max(1.0, float(np.abs(spread).max()))) < 2:
        along = np.lexsort(points.T)
        return np.asarray(points[[along[0], along[-1]]])
    from scipy.spatial import ConvexHull  # 40 MB: only where plans are made

    around = points[ConvexHull(points).vertices]
    return np.vstack([around, around[:1]])
