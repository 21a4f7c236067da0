"""The dialog that opens recordings and scenes: folders, files that were opened last, and uploads from this browser."""

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui
from nicegui.elements.upload import Upload
from nicegui.events import UploadEventArguments

from ods.base.files.shipped import FOLDER as SHIPPED
from ods.workbench.engine.files import browsing, uploads
from ods.workbench.engine.files.browsing import Entry
from ods.workbench.engine.files.folders import uploads_folder
from ods.workbench.engine.files.openable import ENDINGS, opening
from ods.workbench.model.actions import OpenData
from ods.workbench.model.state import State
from ods.workbench.pages.parts.tips import tip
from ods.workbench.session import Session
from ods.workbench.web.follow import follow

MOST_SHOWN = 200
REFUSAL = f"not taken: one file, no folder, ending in {', '.join(ENDINGS)}, of {uploads.MOST_BYTES >> 20} MB at most"
RECENT = "opened last"
TALL = "height: min(calc(100vh - 23rem), 34rem)"


class OpenDialog:
    """Built once a page; filled when it is opened."""

    def __init__(self, session: Session, take: Callable[[OpenData], object] | None = None) -> None:
        """take: does what is chosen; None: it is opened."""
        self._session = session
        self._take_choice = take or session.do
        self._folder: Path | None = None
        self._entries: list[Entry] = []
        self._asked = object()
        """What was asked for last: a listing that comes later is of no use."""
        with ui.dialog() as self._dialog, ui.card().classes("w-[60rem] max-w-full gap-2 p-3").mark("open dialog"):
            with ui.row().classes("w-full items-center no-wrap"):
                ui.label("Open").classes("text-lg")
                self._filter = ui.input("filter", on_change=self._show).props("dense clearable").classes("w-48 ml-auto")
            with ui.row().classes("w-full no-wrap gap-3").style(TALL):
                self._places = ui.list().props("dense").classes("w-44 shrink-0 h-full overflow-auto").mark("places")
                with ui.column().classes("grow min-w-0 h-full gap-1 flex-nowrap"):
                    self._build_where()
                    self._list = ui.list().props("dense separator").classes("w-full grow overflow-auto").mark("entries")
            self._path = ui.input("path of a file, or of a folder of segments").props("dense").classes("w-full")
            self._path.on("keydown.enter", lambda: self._open(self._path.value or ""))
            self._upload = self._build_upload()
        follow(session, self._dialog, self._note)

    def _build_where(self) -> None:
        with ui.row().classes("w-full items-center no-wrap gap-1"):
            self._up = tip(ui.button(icon="arrow_upward", on_click=self._go_up).props("dense flat"), "the folder above")
            self._where = ui.label().classes("text-sm opacity-80 grow min-w-0 truncate").mark("where")
            self._whole = ui.button("open this folder", on_click=lambda: self._open(str(self._folder)))
            self._whole.props("dense flat no-caps").tooltip("segments of one recording").mark("open folder")

    def _build_upload(self) -> Upload:
        upload = ui.upload(
            label="from this browser's computer: choose with +, or drop a file here", auto_upload=True,
            on_upload=self._take, max_file_size=uploads.MOST_BYTES,
            on_rejected=lambda: ui.notify(REFUSAL, type="negative", close_button=True),
        )  # fmt: skip
        upload.props(f'accept="{",".join(ENDINGS)}" flat bordered').classes("w-full").mark("drop")
        return upload

    def open(self) -> None:
        """Show it, with the files that were opened last, or where there are none the first folder."""
        self._dialog.open()
        self._show_places()
        asked = self._asked = object()
        with self._dialog:
            ui.timer(0.0, partial(self._begin, asked), once=True)

    async def _begin(self, asked: object) -> None:
        last = await asyncio.to_thread(browsing.recent, self._session.folders)
        if self._asked is not asked:
            return  # a folder was chosen meanwhile
        if last or not self._session.folders:
            self._show_recent(last)
        else:
            await self._go(self._session.folders[0])

    def _show_places(self) -> None:
        own = uploads_folder()
        places = [(folder.name or str(folder), folder, "folder") for folder in self._session.folders]
        places += [("scenes of ODS", SHIPPED / "scenes", "waves")]
        places += [("uploads", own, "upload_file")] if own is not None and own.is_dir() else []
        self._places.clear()
        with self._places:
            _item(RECENT, "", "history", self._go_recent)
            for name, folder, icon in places:
                _item(name, "", icon, partial(self._go, folder)).tooltip(str(folder))

    async def _go_recent(self) -> None:
        asked = self._asked = object()
        last = await asyncio.to_thread(browsing.recent, self._session.folders)
        if self._asked is asked:
            self._show_recent(last)

    def _show_recent(self, last: list[Entry]) -> None:
        self._folder, self._entries = None, last
        self._where.set_text(RECENT if last else f"{RECENT}: nothing yet")
        self._whole.set_visibility(False)
        self._up.disable()
        self._filter.set_value("")
        self._show()

    async def _go(self, folder: Path) -> None:
        asked = self._asked = object()
        listed = await asyncio.to_thread(browsing.listing, folder, self._session.folders)
        if self._asked is not asked:
            return
        self._folder, self._entries = folder, listed.entries
        more = f", the first {browsing.MOST_LISTED}" if listed.is_cut else ""
        self._where.set_text(f"{folder}: {len(listed.entries)}{more}")
        self._whole.set_visibility(listed.is_recording)
        self._up.enable()
        self._filter.set_value("")
        self._show()

    async def _go_up(self) -> None:
        if self._folder is not None:
            await self._go(self._folder.parent)

    def _show(self) -> None:
        wanted = (self._filter.value or "").casefold()
        found = [each for each in self._entries if wanted in each.name.casefold()]
        self._list.clear()
        with self._list:
            for each in found[:MOST_SHOWN]:
                go = each.is_folder and self._folder is not None
                does = partial(self._go, each.path) if go else partial(self._open, str(each.path))
                _item(each.name, _about(each), "folder" if each.is_folder else "description", does)
            if len(found) > MOST_SHOWN:
                ui.label(f"and {len(found) - MOST_SHOWN} more: filter").classes("text-sm p-2")
            elif not found:
                ui.label("nothing that can be opened").classes("text-sm opacity-70 p-2")

    async def _open(self, path: str) -> None:
        if path:
            action = await asyncio.to_thread(opening, path, self._session.folders)
            self._take_choice(action)
            self._dialog.close()

    async def _take(self, event: UploadEventArguments) -> None:
        self._upload.reset()
        kept = await uploads.keep(event.file)
        ui.notify(f"kept: {kept}", type="positive")
        await self._open(str(kept))

    def _note(self, before: State, after: State) -> None:
        if after.data.path and after.data != before.data and after.data.kind in ("file", "scene"):
            browsing.note(after.data.path)


def _item(name: str, about: str, icon: str, does: Callable[[], Any]) -> ui.item:
    with ui.item(on_click=does).classes("min-h-8 py-0 px-2") as item:
        with ui.item_section().props("avatar").classes("min-w-0 pr-2"):
            ui.icon(icon, size="xs")
        with ui.item_section().classes("min-w-0"):
            ui.item_label(name).classes("truncate")
        if about:
            with ui.item_section().props("side"):
                ui.label(about).classes("text-xs")
    return item


def _about(entry: Entry) -> str:
    if entry.is_folder:
        return ""
    size = f"{entry.size / 1e6:.1f} MB" if entry.size >= 1e5 else f"{entry.size / 1e3:.1f} kB"
    return f"{size}   {datetime.fromtimestamp(entry.changed_s, UTC):%Y-%m-%d %H:%M}"
