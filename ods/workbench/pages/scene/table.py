"""All objects of a scene as a table: places and speed as numbers to be typed, copied and taken out."""

import math
from functools import partial

from nicegui import ui

from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.model.actions import Action, CopyObject, RemoveObject, SetScene
from ods.workbench.model.scene.handles import place_at
from ods.workbench.pages.parts.tips import tip
from ods.workbench.pages.scene.panels import try_to
from ods.workbench.session import Session
from ods.workbench.web.follow import follow

COLUMNS = ("object", "shape", "north, m", "east, m", "down, m", "speed, m/s", "course, °", "", "")
AXES = ("north", "east", "down")
NUMBERS = (*AXES, "speed", "course")
BESIDE_M = 5.0
"""East of an object is its copy."""


class SceneTable:
    """A dialog with a row for each object."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._numbers: dict[str, ui.number] = {}
        """By what they show: "objects[0] north"."""
        self._built: object = None
        with ui.dialog() as self._dialog, ui.card().classes("max-w-none"):
            ui.label("Objects; of those on way-points where they begin").classes("text-base")
            self._rows = ui.grid(columns=" ".join(["auto"] * len(COLUMNS))).classes("gap-x-3 gap-y-0 items-center")
        follow(session, self._rows, lambda *_: self._show())

    def open(self) -> None:
        """Show it."""
        self._dialog.open()
        self._show()

    def _show(self) -> None:
        """Show the numbers as they are; rows are built again only for other objects, so that typing goes on."""
        scene = self._session.state.scene
        if not self._dialog.value or scene is None:
            return
        objects = [(type(item), item.name, bool(item.waypoints)) for item in scene.objects]
        if objects != self._built:
            self._built = objects
            self._build(scene)
        for what, value in numbers_of(scene).items():
            self._numbers[what].set_value(round(value, 2) + 0.0)  # no -0

    def _build(self, scene: SceneFile) -> None:
        self._rows.clear()
        with self._rows:
            for title in COLUMNS:
                ui.label(title).classes("text-xs opacity-70")
            for at, item in enumerate(scene.objects):
                ui.label(item.name)
                ui.label(type(item).__name__.lower()).classes("opacity-70")
                self._row(at, straight=not item.waypoints)

    def _row(self, at: int, *, straight: bool) -> None:
        of = f"objects[{at}]"
        for name in NUMBERS:
            number = ui.number().props(f'dense borderless aria-label="{name}"').classes("w-20").mark(f"{of} {name}")
            number.set_enabled(straight)
            number.on("change", partial(self._give, at, name))
            self._numbers[f"{of} {name}"] = number
        copy = ui.button(icon="content_copy", on_click=partial(self._do, CopyObject(at, (0.0, BESIDE_M, 0.0))))
        tip(copy.props("flat round dense size=sm"), "another like it, to the east").mark(f"copy {of}")
        gone = ui.button(icon="delete", on_click=partial(self._do, RemoveObject(at)))
        tip(gone.props("flat round dense size=sm"), "take it out").mark(f"remove {of}")

    def _give(self, at: int, name: str) -> None:
        """Take a number that was typed; one that cannot be is shown as it was."""
        of, scene = f"objects[{at}]", self._session.state.scene
        typed = self._numbers[f"{of} {name}"].value
        if typed is None or scene is None:
            self._show()
        elif name in AXES:
            self._do(SetScene(f"{of}.position_ned[{AXES.index(name)}]", float(typed)))
        else:
            speed, course = (float(self._numbers[f"{of} {each}"].value or 0.0) for each in ("speed", "course"))
            north, east = (speed * share(math.radians(course)) for share in (math.cos, math.sin))
            down = scene.objects[at].velocity_ned[2]
            self._do(SetScene(f"{of}.velocity_ned", [round(north, 4) + 0.0, round(east, 4) + 0.0, down]))

    def _do(self, action: Action) -> None:
        try_to(self._session, action)
        self._show()


def numbers_of(scene: SceneFile) -> dict[str, float]:
    """Return the numbers of all objects: "objects[0] north"; without speed there is no course."""
    found: dict[str, float] = {}
    for at, item in enumerate(scene.objects):
        of = f"objects[{at}]"
        for name, value in zip(AXES, place_at(scene, of, 0.0), strict=True):
            found[f"{of} {name}"] = value
        north, east, _ = item.velocity_ned
        found[f"{of} speed"] = math.hypot(north, east)
        if north or east:
            found[f"{of} course"] = math.degrees(math.atan2(east, north)) % 360.0
    return found
