"""Menu 5, Utilities: save, presets, links, prints, movies and macros."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from nicegui import ui

from ods.base.errors import OdsError
from ods.workbench.engine import printing
from ods.workbench.engine.background.own_process import in_own_process, whole
from ods.workbench.engine.echogram.layers import Layers, layers_of
from ods.workbench.engine.files import presets
from ods.workbench.engine.files.config_file import for_folder, saving, write_config
from ods.workbench.engine.files.folders import readable
from ods.workbench.engine.files.macro_run import write_macro
from ods.workbench.engine.mission.rerun import wanted
from ods.workbench.model.actions import SetBookmark, SetState, ShowPing
from ods.workbench.model.macro import macro_of
from ods.workbench.model.state import State
from ods.workbench.pages.echogram import echogram_of
from ods.workbench.pages.parts import sending, shared_link
from ods.workbench.pages.parts.reruns import rerun_of
from ods.workbench.pages.parts.tips import tip
from ods.workbench.session import Session
from ods.workbench.web.follow import follow, in_loop


def build(session: Session) -> None:
    """Build the menu."""
    with ui.element("div").classes("w-full columns-1 lg:columns-2 2xl:columns-3 gap-3"):
        for title, card in _CARDS.items():
            with ui.card().classes("w-full mb-3 break-inside-avoid").props("flat bordered"):
                ui.label(title).classes("text-base font-medium")
                card(session)


def _save(session: Session) -> None:
    """Build the difference to the configuration loaded, and what writes it: never without having been seen."""
    shown = ui.code(language="diff").classes("w-full text-xs max-h-80 overflow-auto")
    note = ui.label().classes("text-sm")
    name = ui.input("file to write", value=_beside(session)).classes("w-full")

    def show(*_: State) -> None:
        would = saving(session.loaded, session.state.tuning)
        shown.set_content(would.difference(session.loaded) or "as it was loaded")
        count = len(would.changes)
        note.set_text(f"{'1 setting differs' if count == 1 else f'{count} settings differ'} from {session.loaded.path}")

    def save(place: Path) -> None:
        text = saving(session.loaded, session.state.tuning).text
        if any(place.is_relative_to(folder) for folder in session.folders):  # else it goes to another computer
            text = for_folder(text, session.loaded, place.parent)
        write_config(text, place, [place.parent])

    def load() -> None:
        session.load(readable(name.value, session.folders))
        show()

    with ui.row():
        sending.buttons(session, "Save", lambda: name.value or "", save)
        ui.button("Load", on_click=load).props("dense no-caps outline").mark("load")
    ui.label("On board: ods run --config FILE. On the bench: ods bench --onboard FILE.").classes("text-xs opacity-70")
    follow(session, shown, show)
    show()


def _beside(session: Session) -> str:
    folder = session.folders[0] if session.folders else Path()
    return str(folder / f"{session.loaded.path.stem}-tuned.toml")


def _presets(session: Session) -> None:
    """Build the list of states kept by name."""
    chosen = ui.select(presets.preset_names(session.folders), label="kept").classes("w-full")
    name = ui.input("keep all as it is now as").classes("w-full")

    def load(wanted: str | None) -> None:
        if wanted:
            state = presets.load_preset(wanted, session.state, session.folders)
            session.do(SetState(state, f"preset {wanted}"))

    def keep() -> None:
        file = presets.save_preset(name.value or "", session.state, session.folders)
        chosen.set_options(presets.preset_names(session.folders))
        ui.notify(f"kept: {file}", type="positive")

    async def send() -> None:
        await sending.send(presets.file_name(name.value or "preset"), lambda place: presets.write(place, session.state))

    chosen.on_value_change(lambda event: load(event.value))
    with ui.row():
        ui.button("Keep", on_click=keep).props("dense no-caps").mark("keep preset")
        sending.download("keep", send)


def _share(session: Session) -> None:
    """Build the link of the state, and a field that takes another's."""
    link = ui.textarea("add this to the link of a workbench that has the data: it shows all as here").classes("w-full")
    link.props("readonly rows=3").mark("link")
    taken = ui.input("show what somebody sent").classes("w-full")

    def show(*_: State) -> None:
        link.set_value(shared_link.link_of(session))

    with ui.row():
        ui.button("Copy", on_click=lambda: ui.clipboard.write(link.value or "")).props("dense no-caps")
        show_it = ui.button("Show", on_click=lambda: shared_link.take(session, taken.value or ""))
        show_it.props("dense no-caps outline").mark("take link")
    follow(session, link, show)
    show()


def _print(session: Session) -> None:
    """Build what draws the ping that is shown, or the echogram, for paper."""
    with ui.row().classes("w-full items-end"):
        what = ui.select({"ping": "the ping", "echogram": "the echogram"}, value="ping", label="what")
        what.mark("printed")
        name = ui.input("file: .png, .svg or .pdf", value=_new_file(session, "ping.png")).classes("grow")
        style = ui.select(["light", "dark"], value="light", label="style")
    what.on_value_change(lambda: name.set_value(_new_file(session, f"{what.value}.png")))

    def draw(place: Path) -> None:
        state = session.state
        if what.value == "echogram":
            _draw_echogram(session, state, place, style.value)
        else:
            in_own_process(printing.ping_of, whole, state, session.folders, place, style=style.value)

    sending.buttons(session, "Print", lambda: name.value or "", draw)


def _draw_echogram(session: Session, state: State, place: Path, style: str) -> None:
    """Draw the echogram with the detections and tracks that are known by now."""
    tracked, echogram = rerun_of(session), echogram_of(session).whole(state)
    layers = Layers()
    if tracked.result is not None and tracked.result_of == wanted(state):
        layers = layers_of(tracked.result, echogram, state.view.echogram_beam)
    in_own_process(printing.echogram_of, whole, echogram, layers, state, place, style=style)


def _movie(session: Session) -> None:
    """Build what records the whole run as a movie, and stops on request."""
    name = ui.input("file: .webp or .gif", value=_new_file(session, "mission.webp")).classes("w-full")
    bar = ui.linear_progress(0.0, show_value=False).classes("w-full")
    stops: list[bool] = []

    def progress(share: float) -> bool:
        in_loop(bar, lambda: bar.set_value(share))
        return not stops

    def record(place: Path) -> None:
        stops.clear()
        in_own_process(printing.movie_of, progress, session.state, session.folders, place, style="dark")

    with ui.row():
        sending.buttons(session, "Record", lambda: name.value or "", record)
        ui.button("Stop", on_click=lambda: stops.append(True)).props("dense no-caps outline").mark("stop movie")


def _new_file(session: Session, name: str) -> str:
    return str((session.folders[0] if session.folders else Path()) / name)


def _macro(session: Session) -> None:
    """Build the script of what was done until now, and what writes it with the commands that do the same."""
    script = ui.code(language="python").classes("w-full text-xs max-h-80 overflow-auto")
    folder = ui.input("folder to write script, commands and their files into", value=_new_file(session, "macro"))
    folder.classes("w-full")

    def show(*_: State) -> None:
        lines = macro_of(session.history).script.splitlines()
        script.set_content("\n".join(line if len(line) < 120 else f"{line[:117]}..." for line in lines[6:]))

    sending.buttons(
        session, "Write", lambda: folder.value or "", lambda place: write_macro(session.history, session.loaded, place)
    )
    follow(session, script, show)
    show()


def _bookmarks(session: Session) -> None:
    """Build the list of marked pings."""
    rows = ui.column().classes("w-full gap-0")
    text = ui.input("mark the ping that is shown as").classes("w-full")

    shown: list[object] = []

    def show(*_: State) -> None:
        if shown == [session.state.bookmarks]:
            return
        shown[:] = [session.state.bookmarks]
        rows.clear()
        with rows:
            for mark in session.state.bookmarks:
                with ui.row().classes("w-full items-center"):
                    ui.link(f"ping {mark.ping}: {mark.text}").on("click", partial(session.do, ShowPing(mark.ping)))
                    ui.space()
                    gone = ui.button(icon="close", on_click=partial(session.do, SetBookmark(mark.ping, "")))
                    tip(gone.props("flat round dense size=sm"), "take the mark away")

    def mark() -> None:
        if not text.value:
            raise OdsError("bookmark: needs a text")
        session.do(SetBookmark(session.state.ping, text.value))
        text.set_value("")

    ui.button("Mark", on_click=mark).props("dense no-caps").mark("mark ping")
    follow(session, rows, show)
    show()


_CARDS: dict[str, Callable[[Session], None]] = {
    "Configuration for the vehicle": _save,
    "Presets": _presets,
    "Bookmarks": _bookmarks,
    "Share": _share,
    "Print": _print,
    "Movie of the mission": _movie,
    "Macro": _macro,
}
