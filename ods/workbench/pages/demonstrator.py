"""Menu 4, Demonstrator: the gallery."""

import threading
from collections.abc import Iterable

from nicegui import ui

from ods.base.errors import one_line
from ods.workbench.engine.gallery.demos import Demo, demos
from ods.workbench.engine.gallery.results import Result, gallery_folder, kept, made
from ods.workbench.model.actions import SetState
from ods.workbench.model.state import State, Tuning
from ods.workbench.session import Session
from ods.workbench.web.follow import in_loop


def build(session: Session) -> None:
    """Build the menu: what was made before shows at once, the rest is made in the background."""
    base = State(tuning=Tuning(session.loaded.config), view=session.state.view)
    cards = [_Card(session, demo, base) for demo in _shown(session)]
    ends = threading.Event()
    with ui.element().classes("hidden") as marker:
        marker.client.on_delete(ends.set)
    waiting = sorted((card for card in cards if card.waits), key=lambda card: card.lasts)
    if waiting:
        threading.Thread(target=_make, args=(waiting, ends), daemon=True, name="gallery").start()


def _shown(session: Session) -> Iterable[Demo]:
    ui.label("Pictures are made once, with the configuration at the workbench's start, and kept.").classes("text-sm")
    grid = ui.element("div").classes("w-full grid grid-cols-1 lg:grid-cols-2 2xl:grid-cols-3 gap-3")
    for demo in demos(session.folders):
        with grid:
            yield demo


def _make(cards: list["_Card"], ends: threading.Event) -> None:
    for card in cards:
        if ends.is_set():
            return
        card.make(ends)


class _Card:
    """One demo."""

    def __init__(self, session: Session, demo: Demo, base: State) -> None:
        self._session, self._demo, self._base = session, demo, base
        with ui.card().classes("w-full gap-1").props("flat bordered").mark(f"demo {demo.key}") as self._card:
            with ui.row().classes("w-full items-center no-wrap"):
                ui.label(demo.title).classes("text-base font-medium grow")
                if not demo.missing:
                    opens = ui.button("Open", icon="open_in_new", on_click=self._open).props("flat dense no-caps")
                    opens.mark(f"open {demo.key}").tooltip("in all other menus")
            self._picture = ui.column().classes("w-full items-center justify-center gap-1").style("min-height: 120px")
            self._facts = ui.label().classes("text-xs opacity-70").mark(f"facts {demo.key}")
            for sentence in demo.look:
                ui.label(sentence).classes("text-sm")
        self.lasts = demo.file is None
        """A mission, not a single image."""
        self.waits = not demo.missing and not self._show_kept()
        with self._picture:
            if demo.missing:
                ui.label(f"Not here: {demo.missing}.").classes("text-sm text-warning")
            elif self.waits:
                self._progress = ui.linear_progress(value=0.0, show_value=False).props("instant-feedback")
                ui.label("being made, once").classes("text-xs opacity-70")

    def make(self, ends: threading.Event) -> None:
        """Make the pictures, in the thread of the caller, and show them."""

        def progress(share: float) -> bool:
            self._tell(share)
            return not ends.is_set()

        try:
            result = made(self._demo, self._base, gallery_folder(), progress)
        except Exception as error:  # a bad file does not take the others away
            why = one_line(error)
            in_loop(self._card, lambda: self._say(why))
        else:
            if result is not None:
                in_loop(self._card, lambda: self._show(result))

    def _tell(self, share: float) -> None:
        if round(100 * share) % 5 == 0:
            in_loop(self._progress, lambda: self._progress.set_value(share))

    def _show_kept(self) -> bool:
        result = kept(self._demo, self._base, gallery_folder())
        if result is not None:
            self._show(result)
        return result is not None

    def _show(self, result: Result) -> None:
        self._picture.clear()
        with self._picture:
            for picture in result.pictures:
                ui.image(picture).classes("w-full").props("fit=contain no-spinner")
        self._facts.set_text(result.facts)

    def _say(self, why: str) -> None:
        self._picture.clear()
        with self._picture:
            ui.label(why).classes("text-sm text-negative")

    def _open(self) -> None:
        base = State(tuning=self._base.tuning, view=self._session.state.view, scene=self._session.state.scene)
        self._session.do(SetState(self._demo.state(base), f"gallery: {self._demo.title}"))
        ui.notify(f"{self._demo.title}: open in all menus, as Image processing and Observer")
