"""The bar over the simulator: opens a scene or begins one, and with one open chooses the sonar and saves."""

import msgspec
from nicegui import ui

from ods.workbench.engine.files.openable import opening, shipped_scenes
from ods.workbench.engine.scene.file import shipped_sonars
from ods.workbench.model import actions as do
from ods.workbench.model.scene.edits import NEW
from ods.workbench.model.state import DataReference
from ods.workbench.pages.scene.saving import SaveDialog
from ods.workbench.session import Session

NONE_OPEN = "No scene is open: choose or begin one, or start the workbench with a SCENE.toml."


def open_bar(session: Session) -> None:
    """Build what opens a scene; with one open also what saves it and adds to it."""
    scenes, state = {each.name: each.path for each in shipped_scenes()}, session.state

    def open_scene(name: str) -> None:
        opened = opening(scenes[name], session.folders)
        data = msgspec.structs.replace(opened.data, sonar=session.state.data.sonar)
        session.do(do.OpenData(data, opened.scene))

    with ui.row().classes("items-center gap-2"):
        select = ui.select(list(scenes), label="open a scene of ODS").props("dense options-dense").classes("w-48")
        select.mark("open scene").on_value_change(lambda event: open_scene(event.value))
        new = ui.button("New scene", icon="add", on_click=lambda: _begin(session)).props("flat dense no-caps")
        new.mark("new scene")
        if state.scene is None:
            ui.label(NONE_OPEN).classes("text-sm")
            return
        sonar = ui.select(sorted({*shipped_sonars(), state.data.sonar}), value=state.data.sonar, label="sonar")
        sonar.props("dense options-dense").classes("w-44").mark("sonar")
        sonar.on_value_change(lambda event: _seen_by(session, event.value))
        dialog = SaveDialog(session)
        ui.button("Save ...", icon="save", on_click=dialog.open).props("flat dense no-caps").mark("save scene")


def _begin(session: Session) -> None:
    session.do(do.OpenData(DataReference(kind="scene", path="", sonar=session.state.data.sonar), NEW))


def _seen_by(session: Session, sonar: str) -> None:
    data = session.state.data
    path = data.path if data.kind == "scene" else ""
    session.do(do.OpenData(DataReference(kind="scene", path=path, sonar=sonar)))
