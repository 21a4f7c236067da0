"""All objects of a scene as a table: places and speed as numbers to be typed, copied and taken out."""

import math

from nicegui import ui

from ods.workbench.model.actions import CopyObject, RemoveObject, SetScene
from ods.workbench.model.scene_handles import place_at
from ods.workbench.model.state import State
from ods.workbench.pages.scene_panels import try_to
from ods.workbench.session import Session
from ods.workbench.web.follow import follow

COLUMNS = ("object", "shape", "north, m", "east, m", "down, m", "speed, m/s", "course, °", "", "")
AXES = ("north", "east", "down")
BESIDE_M = 5.0
"""East of an object is its copy."""


class SceneTable:
    """A dialog with a row for each object."""

    def __init__(self, session: Session) -> None:
        self._session = session
        with ui.dialog() as self._dialog, ui.card().classes("max-w-none"):
            ui.label("Objects; of those on way-points where they begin").classes("text-base")
            self._rows = ui.grid(columns=" ".join(["auto"] * len(COLUMNS))).classes("gap-x-3 gap-y-0 items-center")
        follow(session, self._rows, self._changed)

    def open(self) -> None:
        """Show it."""
        self._dialog.open()
        self._build()

    def _changed(self, before: State, after: State) -> None:
        if self._dialog.value and before.scene != after.scene:
            self._build()

    def _build(self) -> None:
        self._rows.clear()
        scene = self._session.state.scene
        with self._rows:
            for title in COLUMNS:
                ui.label(title).classes("text-xs opacity-70")
            for at in range(len(scene.objects) if scene is not None else 0):
                self._row(at)

    def _row(self, at: int) -> None:
        scene, of = self._session.state.scene, f"objects[{at}]"
        if scene is None:
            return
        item = scene.objects[at]
        ui.label(item.name)
        ui.label(type(item).__name__.lower()).classes("opacity-70")
        straight = not item.waypoints
        for axis, value in enumerate(place_at(scene, of, 0.0)):
            self._number(f"{of} {AXES[axis]}", value, straight, f"{of}.position_ned[{axis}]")
        north, east, down = item.velocity_ned
        speed = self._number(f"{of} speed", math.hypot(north, east), straight)
        course = self._number(f"{of} course", math.degrees(math.atan2(east, north)) % 360.0, straight)

        def sail() -> None:
            if speed.value is not None and course.value is not None:
                to = math.radians(course.value)
                velocity = [round(speed.value * share, 4) + 0.0 for share in (math.cos(to), math.sin(to))]
                try_to(self._session, SetScene(f"{of}.velocity_ned", [*velocity, down]))

        for each in (speed, course):
            each.on("change", sail)
        copy = ui.button(icon="content_copy", on_click=lambda: self._copy(at)).props("flat round dense size=sm")
        copy.tooltip("another like it, to the east").mark(f"copy {of}")
        gone = ui.button(icon="delete", on_click=lambda: try_to(self._session, RemoveObject(at)))
        gone.props("flat round dense size=sm").tooltip("take it out").mark(f"remove {of}")

    def _number(self, marker: str, value: float, editable: bool, path: str = "") -> ui.number:
        number = ui.number(value=round(value, 2) + 0.0).props("dense borderless").classes("w-20").mark(marker)
        number.set_enabled(editable)
        if path:
            number.on("change", lambda: self._give(path, number.value))
        return number

    def _give(self, path: str, value: float | None) -> None:
        if value is not None:
            try_to(self._session, SetScene(path, float(value)))
        self._build()

    def _copy(self, at: int) -> None:
        try_to(self._session, CopyObject(at, (0.0, BESIDE_M, 0.0)))
