"""Labels drawn over real frames, so that a recording becomes a test set: a row of tools under the tool bar."""

import asyncio
from functools import partial
from pathlib import Path
from typing import Literal, cast

from nicegui import ui

from ods.base.errors import OdsError
from ods.workbench.engine.ping import labels
from ods.workbench.model import actions as do
from ods.workbench.model.state import Label, State
from ods.workbench.pages.parts import sending
from ods.workbench.session import Session
from ods.workbench.web.follow import follow
from ods.workbench.web.views.fan_view import FanView

Shape = Literal["rectangle", "ellipse"]
NO_FRAMES = "labels: for recordings; of a scene the truth is known"
LONGEST = 30
"""Characters of a label's text in its chip."""


class Labelling:
    """The tools, which are hidden until they are asked for; a drag in a picture draws while they are shown."""

    def __init__(self, session: Session, views: tuple[FanView, ...]) -> None:
        self._session, self._views = session, views
        self._drawn_of: tuple[object, ...] = ()
        with ui.column().classes("w-full gap-1") as self._tools:
            with ui.row().classes("w-full items-center no-wrap gap-2"):
                self._shape = ui.toggle(["rectangle", "ellipse"], value="rectangle", on_change=self._arrange)
                self._shape.props("dense no-caps").mark("label shape")
                self._text = ui.input("what it looks like").props("dense maxlength=80").classes("w-36 shrink-0")
                self._chips = ui.row().classes("grow min-w-0 items-center gap-1").mark("labels")
            with ui.row().classes("w-full items-center no-wrap gap-2"):
                self._file = ui.input("file of labels", value=self._proposed()).props("dense").classes("grow min-w-0")
                sending.buttons(session, "Save", lambda: self._file.value or "", self._write)
                ui.button("Load", on_click=self._load).props("dense no-caps outline").mark("load labels")
        self._tools.set_visibility(False)
        for view in views:
            view.on_drawn(self._add)
        follow(session, self._tools, self._follow)

    @property
    def shown(self) -> bool:
        """Whether labels are drawn now."""
        return bool(self._tools.visible)

    def toggle(self) -> None:
        """Show the tools, or hide them. Raises OdsError where there is nothing to label."""
        if not self.shown and self._session.state.data.kind != "file":
            raise OdsError(NO_FRAMES)
        self._tools.set_visibility(not self.shown)
        self._arrange()
        self._show()

    def _arrange(self) -> None:
        for view in self._views:
            view.set_drawing(str(self._shape.value) if self.shown else "")

    def _add(self, beams: tuple[int, int], samples: tuple[int, int]) -> None:
        shape = cast("Shape", self._shape.value)
        text = "".join(filter(str.isprintable, self._text.value or "")).replace("#", "")
        self._session.do(do.AddLabel(Label(self._session.state.ping, beams, samples, shape, text.strip())))

    def _follow(self, before: State, after: State) -> None:
        if before.data != after.data:
            self._file.set_value(self._proposed())
            if self.shown and after.data.kind != "file":
                self.toggle()
        self._show()

    def _show(self) -> None:
        state = self._session.state
        if not self.shown or self._drawn_of == (state.ping, state.labels):
            return
        self._drawn_of = state.ping, state.labels
        here = [(at, each) for at, each in enumerate(state.labels) if each.ping == state.ping]
        self._chips.clear()
        with self._chips:
            frames = len({each.ping for each in state.labels})
            count = f"labels: {len(state.labels)}, frames with labels: {frames}; of this one:"
            said = count if state.labels else "drag over a picture to label what is to be found there"
            ui.label(said).classes("text-xs opacity-80")
            for number, (at, each) in enumerate(here, 1):
                name = f"{number} {each.text}"[:LONGEST].strip()
                with ui.button(name, icon="close", on_click=partial(self._session.do, do.RemoveLabel(at))) as chip:
                    chip.props("dense no-caps outline size=sm").tooltip("take this label away")

    def _proposed(self) -> str:
        folder = self._session.folders[0] if self._session.folders else Path()
        return str(folder / f"{Path(self._session.state.data.path).stem or 'frames'}-labels.txt")

    def _write(self, place: Path) -> None:
        labels.write(place, self._session.state)

    async def _load(self) -> None:
        session, name = self._session, self._file.value or ""
        found = await asyncio.to_thread(labels.read, name, session.state, session.folders)
        session.do(do.SetLabels(found, f"labels of {Path(name).name}"))
