"""Objects of a scene: those that must be found, and their distance from a position."""

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.bodies.bodies import CYLINDER, PLANE, Body, circle_radius
from ods.sim_sonar.scene.settings import Plane
from ods.sim_sonar.scene.timeline import Scene

SURFACE = "surface"
"""Objects of this name make the water's surface: echoes, but no obstacles."""


def group_of(name: str) -> str:
    """Return what an object is part of: `school/7` is one of the school; what has no / is a group of its own."""
    return name.partition("/")[0]


class SceneObjects:
    """The obstacles of a scene, in groups that count as one."""

    def __init__(self, scene: Scene, clearance_m: float) -> None:
        """clearance_m: what is nowhere higher than this over the sea-bed, at the start, need not be tracked."""
        items, bodies = scene.file.objects, scene.bodies_at(0.0)
        self._scene = scene
        self._rows = [k for k, item in enumerate(items) if group_of(item.name) != SURFACE]
        self.groups = [group_of(items[k].name) for k in self._rows]
        """(n,) of each obstacle."""
        tall = {
            group_of(items[k].name)
            for k in self._rows
            if not isinstance(items[k], Plane) and _top_over_bottom(scene, bodies[k]) > clearance_m
        }
        self.targets = sorted(tall)
        """Groups that have to be tracked; flat things, of which a list has many parts, are not among them."""

    def distances(self, t_s: float, places: Floats) -> Floats:
        """Return how far, m, horizontally, places (m, 2) are from each obstacle's edge at scene time `t_s`: (m, n)."""
        bodies = self._scene.bodies_at(t_s)
        columns = [_distance(bodies[k], places) for k in self._rows]
        return np.column_stack(columns) if columns else np.empty((len(places), 0))


def _distance(body: Body, places: Floats) -> Floats:
    """Return the distances of places (m, 2) from a body's outline seen from above, (m,); 0 inside."""
    offset = places - body["centre"][:2]
    if body["kind"] != PLANE:
        return np.asarray(np.maximum(np.hypot(*offset.T) - circle_radius(body), 0.0))
    along = body["axes"][0, :2]
    share = np.clip(offset @ along, -body["half"][0], body["half"][0])
    return np.asarray(np.hypot(*(offset - share[:, None] * along).T))


def _top_over_bottom(scene: Scene, body: Body) -> float:
    if scene.sea_bed is None:
        return float("inf")
    radius, upright = float(body["half"][0]), abs(float(body["axes"][2, 2]))
    up = radius
    if body["kind"] == CYLINDER:
        up = float(body["half"][2]) * upright + radius * float(np.sqrt(max(0.0, 1.0 - upright**2)))
    return scene.sea_bed.height_over(body["centre"]) + up
