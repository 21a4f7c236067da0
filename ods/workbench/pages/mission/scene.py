"""A tracked mission in three dimensions, where the sonar measures heights: ways as points, objects as spheres."""

from collections.abc import Callable, Sequence

import numpy as np
from nicegui import ui
from nicegui.elements.scene import Object3D

from ods.base.arrays import Floats
from ods.messages import Vector3
from ods.workbench.engine.mission.tracked import Tracked
from ods.workbench.pages.parts.tips import tip

MOST_POINTS, MESH = 400, 15
"""Points of a way, and squares of the mesh along its longer side."""
COLOURS = {
    "vehicle": "#e6edf3", "truth": "#ff8c42", "active": "#1fc79a", "stand_by": "#f0b429", "hibernated": "#56b4e9",
    "terminated": "#8b949e", "mesh": "#30363d",
}  # fmt: skip
NOT_KNOWN = "for sonars that measure heights: of several planes, or in three dimensions"
SIZE = (900, 520)
"""Pixels; a window of 1024 x 700 has them."""


def heights_known(result: Tracked | None) -> bool:
    """Return whether there are depths to be seen."""
    return result is not None and result.tells_heights and bool(result.courses)


class SceneDialog:
    """Shows the mission when it is opened, and the ping at hand while it is open."""

    def __init__(self, result: Callable[[], Tracked | None], place: Callable[[], int]) -> None:
        """result, place: what is to be shown, and the ping, at this moment."""
        self._result, self._place = result, place
        self._drawn: Tracked | None = None
        self._moment: list[Object3D] = []
        with ui.dialog() as self._dialog, ui.card().classes("max-w-none gap-1 p-3").mark("scene dialog"):
            with ui.row().classes("w-full items-center"):
                self._title = ui.label().classes("text-sm")
                ui.space()
                tip(ui.button(icon="close", on_click=self._dialog.close).props("flat round dense"), "close (Esc)")
            self._space = ui.element("div")

    def open(self) -> None:
        """Show the mission."""
        result = self._result()
        if result is None:
            return
        self._dialog.open()
        if result is not self._drawn:
            self._drawn = result
            self._space.clear()
            with self._space:
                self._build(result)
        self.show()

    def show(self) -> None:
        """Show the ping at hand, if the dialog is open."""
        result, place = self._result(), self._place()
        if not self._dialog.value or result is None or result is not self._drawn or not 0 <= place < len(result.t_s):
            return
        self._title.set_text(
            f"{result.t_s[place]:.1f} s, ping {place}. Orange: true objects; bars: two standard deviations of depth; "
            f"mesh: {self._step_m:g} m, at the deepest of it all. Drag: turn; wheel: zoom"
        )
        for each in self._moment:
            each.delete()
        with self._scene:
            self._moment = [*self._vehicle(result, place), *self._truths(result, place), *self._tracks(result, place)]

    def _build(self, result: Tracked) -> None:
        self._moment = []
        width, height = SIZE
        with ui.scene(width, height, grid=False, background_color="#0d1117") as self._scene:
            _way(result.path, COLOURS["vehicle"])
            for truth in result.truths:
                _way(truth.position, COLOURS["truth"])
            for course in result.courses:
                _way(course.position, COLOURS["active"])
            low, high = _extent(result)
            self._step_m = _mesh(low, high)
        x, y, z = _xyz(0.5 * (low + high))
        far = max(10.0, float(np.linalg.norm(high - low)))
        self._scene.move_camera(x, y - 0.75 * far, z + 0.4 * far, x, y, z, duration=0.0)

    def _vehicle(self, result: Tracked, place: int) -> Sequence[Object3D]:
        heading = result.heading(place)
        cone = self._scene.cylinder(0.0, 0.4, 1.6).material(COLOURS["vehicle"])
        return [cone.move(*_xyz(result.path[place])).rotate(0.0, 0.0, -heading)]

    def _truths(self, result: Tracked, place: int) -> list[Object3D]:
        shapes: list[Object3D] = []
        for truth in result.truths:
            rows = np.flatnonzero(np.abs(truth.t_s - result.t_s[place]) < 1e-6)
            if len(rows):
                sphere = self._scene.sphere(truth.radius_m, 16, 10, wireframe=True).material(COLOURS["truth"])
                shapes.append(sphere.move(*_xyz(truth.position[rows[0]])))
        return shapes

    def _tracks(self, result: Tracked, place: int) -> list[Object3D]:
        newest = result.list_at(place)
        shapes: list[Object3D] = []
        for item in () if newest is None else newest.obstacles:
            x, y, z = _xyz(item.position_ned)
            colour, two_sigmas = COLOURS[item.state], 2.0 * item.sigma_position[2]
            shapes.append(self._scene.sphere(item.radius_m, 24, 14).material(colour, 0.55).move(x, y, z))
            shapes.append(self._scene.line([x, y, z - two_sigmas], [x, y, z + two_sigmas]).material(colour))
            label = self._scene.text(result.name_of(item.id), f"color: {colour}; font-size: 12px")
            shapes.append(label.move(x, y, z + item.radius_m + 0.6))
        return shapes


def _way(position: Floats, colour: str) -> None:
    """Draw a way as points, of many of them evenly some."""
    chosen = np.unique(np.linspace(0, len(position) - 1, min(len(position), MOST_POINTS)).astype(np.int64))
    points = [list(_xyz(each)) for each in position[chosen]]
    rgb = [int(colour[at : at + 2], 16) / 255.0 for at in (1, 3, 5)]
    if points:
        ui.scene.point_cloud(points, [rgb] * len(points), point_size=0.25)


def _extent(result: Tracked) -> tuple[Floats, Floats]:
    """Return the lowest and the highest NED of all that is shown, (3,) each."""
    tracked, true = [each.position for each in result.courses], [each.position for each in result.truths]
    places = np.vstack([result.path, *tracked, *true])
    return np.asarray(places.min(axis=0)), np.asarray(places.max(axis=0))


def _mesh(low: Floats, high: Floats) -> float:
    """Draw a level mesh at the greatest depth, a little wider than what is shown; return its step, m."""
    span = max(10.0, float((high - low)[:2].max()))
    step_m = next(
        step for step in (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 1000.0) if span / step <= MESH or step == 1000.0
    )
    north0, east0 = (np.floor(low[:2] / step_m) - 1.0) * step_m
    north1, east1 = (np.ceil(high[:2] / step_m) + 1.0) * step_m
    z = -float(high[2])
    rows = [([east0, north, z], [east1, north, z]) for north in np.arange(north0, north1 + 0.5 * step_m, step_m)]
    rows += [([east, north0, z], [east, north1, z]) for east in np.arange(east0, east1 + 0.5 * step_m, step_m)]
    for begin, end in rows:
        ui.scene.line(list(map(float, begin)), list(map(float, end))).material(COLOURS["mesh"])
    return step_m


def _xyz(ned: Floats | Vector3) -> tuple[float, float, float]:
    """Return east, north and up of north, east and down."""
    north, east, down = (round(float(each), 3) for each in ned)
    return east, north, -down
