"""Sliders and switches of a scene, which follow the state as they set it."""

import math
from collections.abc import Sequence
from typing import Any

from nicegui import ui

from ods.workbench.model.actions import Action, RemoveWaypoint, SetScene
from ods.workbench.model.paths import PathError, value_at
from ods.workbench.model.scene.dials import Group
from ods.workbench.model.scene.effects import EFFECTS, Effect, is_on, switch
from ods.workbench.model.sliders import Control
from ods.workbench.model.state import State
from ods.workbench.pages.parts.control_row import ControlRow
from ods.workbench.pages.parts.tips import tip
from ods.workbench.session import Session
from ods.workbench.web.follow import follow


def try_to(session: Session, action: Action) -> None:
    """Do an action, or say why it cannot be done."""
    try:
        session.do(action)
    except PathError as error:
        ui.notify(str(error), type="warning")


def groups(session: Session, shown: Sequence[Group]) -> None:
    """Build the sliders of groups, each under its title."""
    for group in shown:
        if group.dials:
            ui.label(group.title).classes("text-xs opacity-60 mt-1")
        for each in group.dials:
            _row(session, each)


def _row(session: Session, control: Control) -> None:
    """Build a row; what cannot be is shown as it was, and the page says why."""

    def give(value: float) -> None:
        try_to(session, SetScene(control.path, float(value)))
        show()

    def show(_: State | None = None, __: State | None = None) -> None:
        value = _value(session.state, control.path)  # the newest: notifications come later
        if isinstance(value, int | float):
            row.show(value)

    row = ControlRow(control, control.default, give)
    follow(session, row.element, show)
    show()


def effects(session: Session) -> None:
    """Build a switch for each effect."""
    with ui.grid(columns=2).classes("w-full gap-0"):
        for each in EFFECTS:
            _effect(session, each)


def _effect(session: Session, effect: Effect) -> None:
    def set_to(event: Any) -> None:
        scene = session.state.scene
        if scene is not None and is_on(scene, effect) != event.value:
            try_to(session, switch(session.history, effect, event.value))
            show()

    def show(_: State | None = None, __: State | None = None) -> None:
        scene = session.state.scene  # the newest: an older one would be set again
        if scene is not None:
            box.set_value(is_on(scene, effect))

    scene = session.state.scene
    box = ui.switch(effect.label, value=scene is not None and is_on(scene, effect), on_change=set_to)
    box.props("dense").classes("text-sm py-1").mark(f"effect {effect.path}")
    follow(session, box, show)


def waypoints(session: Session, of: str) -> None:
    """Build the table of a path's way-points: time and depth to be typed; places are dragged in the plan."""
    points = value_at(session.state.scene, of)["waypoints"] if session.state.scene else []
    for place, point in enumerate(points):
        with ui.row().classes("items-center no-wrap gap-2"):
            ui.label(f"{place + 1}").classes("text-sm w-4")
            _typed(session, "t", "s", f"{of}.waypoints[{place}].t_s", point["t_s"])
            _typed(session, "depth", "m", f"{of}.waypoints[{place}].position_ned[2]", point["position_ned"][2])
            _place(session, f"{of}.waypoints[{place}].position_ned")
            remove = RemoveWaypoint(of, place)
            close = ui.button(icon="close", on_click=lambda action=remove: try_to(session, action))
            tip(close.props("flat round dense size=sm"), "remove")


def _place(session: Session, path: str) -> None:
    """Build the words for a place that is dragged elsewhere."""

    def show(_: State | None = None, __: State | None = None) -> None:
        north, east, _down = _value(session.state, path) or (math.nan,) * 3
        label.set_text(f"N {north:.1f}, E {east:.1f} m")

    label = ui.label().classes("text-xs opacity-70")
    follow(session, label, show)
    show()


def _value(state: State, path: str) -> Any:
    """Return a value of the scene; None: that part is gone, and its panel goes soon."""
    try:
        return None if state.scene is None else value_at(state.scene, path)
    except PathError:
        return None


def _typed(session: Session, label: str, unit: str, path: str, value: float) -> None:
    number = ui.number(label, value=round(value, 2), suffix=unit).props("dense").classes("w-20").mark(path)

    def set_it() -> None:
        if number.value is not None:
            try_to(session, SetScene(path, float(number.value)))
        show()

    def show(_: State | None = None, __: State | None = None) -> None:
        given = _value(session.state, path)
        if given is not None:
            number.set_value(round(given, 2))

    follow(session, number, show)
    number.on("blur", set_it)
    number.on("keydown.enter", set_it)
