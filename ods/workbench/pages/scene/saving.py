"""The dialog that saves a scene, once its difference to the file that is there was shown."""

import shlex

import msgspec
from nicegui import ui

from ods.base.errors import OdsError, one_line
from ods.workbench.engine.scene.file import SavedScene, proposed, save, saving
from ods.workbench.model.actions import OpenData
from ods.workbench.session import Session


class SaveDialog:
    """Asks for a name, shows the difference, writes."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._prepared: SavedScene | None = None
        with ui.dialog() as self._dialog, ui.card().classes("w-full max-w-3xl"):
            ui.label("Save the scene").classes("text-lg")
            self._name = ui.input("file, under a folder of the workbench", on_change=self._prepare)
            self._name.props("dense").classes("w-full").mark("scene file")
            self._difference = ui.code("", language="diff").classes("w-full max-h-96 overflow-auto")
            with ui.row():
                self._button = ui.button("Save", on_click=self._save).props("dense no-caps").mark("write scene")
                ui.button("Cancel", on_click=self._dialog.close).props("flat dense no-caps")

    def open(self) -> None:
        """Ask."""
        data = self._session.state.data
        self._name.set_value(str(proposed(data.path if data.kind == "scene" else "", self._session.folders)))
        self._prepare()
        self._dialog.open()

    def _prepare(self) -> None:
        scene = self._session.state.scene
        self._prepared = None
        try:
            if scene is not None:
                self._prepared = saving(scene, self._name.value or "", self._session.folders)
        except OdsError as error:
            self._difference.set_content(one_line(error))
        else:
            self._difference.set_content(self._prepared.difference if self._prepared else "")
        if self._prepared is not None and not self._prepared.difference:
            self._difference.set_content("no difference to the file")
        self._button.set_enabled(self._prepared is not None and bool(self._prepared.difference))

    def _save(self) -> None:
        if self._prepared is not None:
            save(self._prepared)
            place = shlex.quote(str(self._prepared.path))
            ui.notify(f"saved {place}; on the bench: ods bench --scene {place}", type="positive")
            self._dialog.close()
            self._follow(str(self._prepared.path))

    def _follow(self, path: str) -> None:
        """The scene is that file's from now on: it is what is saved next, and what is opened again."""
        data = self._session.state.data
        if data.kind == "scene" and data.path != path:
            self._session.do(OpenData(msgspec.structs.replace(data, path=path)))
