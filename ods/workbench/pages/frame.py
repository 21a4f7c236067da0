"""The frame of the page: header with undo and redo, the menus as tabs, and the keys that do the same everywhere."""

import contextlib
import importlib
import importlib.util
import logging
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple
from weakref import WeakKeyDictionary

from nicegui import run, ui
from nicegui.elements.button import Button
from nicegui.events import KeyEventArguments

from ods.base.errors import one_line
from ods.workbench.model.actions import SetView
from ods.workbench.model.state import DataReference
from ods.workbench.pages.parts import shared_link
from ods.workbench.pages.parts.open_dialog import OpenDialog
from ods.workbench.pages.parts.tips import tip
from ods.workbench.session import Session
from ods.workbench.web.follow import PICTURE_FIRST_S, follow, in_loop

log = logging.getLogger(__name__)


class Menu(NamedTuple):
    """A tab. Its module has `build(session)`, which makes the page in NiceGUI's current slot, and may have `KEYS`."""

    name: str
    module: str
    icon: str


MENUS = (
    Menu("Image processing", "ods.workbench.pages.processing", "tune"),
    Menu("Observer", "ods.workbench.pages.observer", "my_location"),
    Menu("Simulator", "ods.workbench.pages.simulator", "waves"),
    Menu("Demonstrator", "ods.workbench.pages.demonstrator", "collections"),
    Menu("Utilities", "ods.workbench.pages.utilities", "build"),
    Menu("Assess", "ods.workbench.pages.assess", "insights"),
    Menu("Live", "ods.workbench.pages.live", "sensors"),
    Menu("Echogram", "ods.workbench.pages.echogram", "stacked_line_chart"),
    Menu("Missions", "ods.workbench.pages.missions", "route"),
)
"""Loaded when first opened; one whose module is not there is not shown."""
KEYS = (
    ("Ctrl Z", "undo"),
    ("Ctrl Y, Ctrl Shift Z", "redo"),
    ("O", "open a recording or a scene"),
    ("P", "fan or beams beside each other"),
    ("D", "dark or light"),
    ("1 ... 9", "menus"),
    ("?", "these keys"),
    ("V, Shift V", "focus on the next or previous picture, plan or chart"),
    ("arrows, with Shift", "there: move the cross, faster"),
    ("Enter, space", "there: click at the cross; take or drop a handle"),
    ("+, -, 0", "there: zoom in, out, show all"),
    ("wheel, drag, double click", "in an image: zoom, pan, show all"),
    ("wheel, drag, double click", "in a chart: zoom, zoom into a box, show all"),
    ("click", "in an image: pin its beam"),
    ("M, or Shift and drag", "in an image or a plan: measure from one place to another"),
)
FIRST_MENU = {"none": 0, "file": 0, "scene": 2, "live": 6}
"""Place in MENUS of what opens first, by the kind of the data."""
SERVER_GONE = "If it has ended: start ods workbench again, and open the link that its terminal shows."
"""Under NiceGUI's own words, which say that the connection is lost: the cookie is good for one start only."""
TEXT_COLOURS = {
    "dark": {"negative": "#ff7b72", "positive": "#3fb950", "warning": "#f2c037"},
    "light": {"negative": "#c10015", "positive": "#137333", "warning": "#8a5a00"},
}
"""Of what failed, is well or needs care; 4.5:1 at least against page and cards (WCAG 2.2, 1.4.3)."""
NARROW = "@media (max-width: 1200px) { header .q-tab { padding: 0 8px; } }"
"""All tabs are seen in a window of 1024 pixels."""
ANSWER = """(name) => {
    element.props["model-value"] = name;
    document.getElementById("menus").dataset.shown = name;
}"""
"""Of the browser to a click at a tab: the tab and the menu's place, whatever the server does; it shows the same later.
`element` is NiceGUI's, where it evaluates this."""
LONGEST_NAME = 44
"""Characters of the name of data or a step in the header; the list of steps has all of it."""

_open_menu: "WeakKeyDictionary[Session, str]" = WeakKeyDictionary()
"""That a page shows which is built again."""


def build(session: Session) -> None:
    """Build the whole page. An error of a handler is shown as one line, and the page goes on."""
    ui.context.client.on_exception(_tell)
    ui.query(".nicegui-content").classes("p-0 gap-0")
    ui.colors(primary="#2f81f7", positive="#137333")  # white is read on it, too
    ui.add_css("".join((*_rules(), *_shown_rules())) + NARROW)
    ui.add_css(f'#popup::after {{ content: "{SERVER_GONE}"; }}')
    dark = ui.dark_mode(session.state.view.dark)
    follow(session, dark, lambda _, after: dark.set_value(after.view.dark))
    menus = _Menus(session)
    with ui.header().classes("items-center gap-1 px-3 py-0").style("background: #161b22; color: #e6edf3"):
        ui.label("ODS workbench").classes("text-base font-medium")
        opens = OpenDialog(session)
        opening = _icon("folder_open", "open a recording or a scene (O)", opens.open).mark("open")
        opening.set_text("Open")
        opening.props(remove="round").props("no-caps")
        _data_name(session)
        ui.space()
        _undo_and_redo(session)
        keys = _Keys(session, menus, opens)
        _icon("contrast", "dark or light (D)", keys.toggle_dark)
        _icon("help_outline", "keys (?)", keys.show)
        with ui.row().classes("w-full"):
            menus.build_tabs()
    menus.build_panels()
    shared_link.take_when_opened(session)


def _rules() -> Iterator[str]:
    for style, colours in TEXT_COLOURS.items():
        for what, colour in colours.items():
            yield f".body--{style} .text-{what} {{ --q-{what}: {colour}; }}\n"  # Quasar's own rule is important


def _shown_rules() -> Iterator[str]:
    """Yield what shows one menu: the one that the browser chose last, which may be ahead of the server."""
    for menu in MENUS:
        yield f'#menus[data-shown]:not([data-shown="{menu.name}"]) > [data-menu="{menu.name}"] {{ display: none; }}\n'


class _Place(ui.column):
    """Of a menu. Whether it is seen is known here, for what follows it, but done by `_shown_rules`."""

    def _handle_visibility_change(self, visible: str) -> None:
        pass


def _icon(icon: str, does: str, clicked: Callable[[], object]) -> Button:
    return tip(ui.button(icon=icon, on_click=lambda: clicked()).props("flat round dense color=white"), does)


def _tell(error: Exception) -> None:
    """Say on the page what went wrong."""
    ui.notify(one_line(error) or type(error).__name__, type="negative", close_button=True)


def _data_name(session: Session) -> None:
    label = ui.label(_short(name_of(session.state.data))).classes("text-sm opacity-80").mark("data")
    follow(session, label, lambda _, after: label.set_text(_short(name_of(after.data))))


def name_of(data: DataReference) -> str:
    """Return what the header calls the data."""
    name = Path(data.path).name or data.path
    if data.kind == "none":
        return "no data open"
    return {"file": name, "scene": f"scene {name or 'not saved yet'}", "live": f"live: {data.path}"}[data.kind]


def _short(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"


def _undo_and_redo(session: Session) -> None:
    """Build two buttons that say what they would do, and the list of all steps."""
    undo = _step_button("undo", "undo (Ctrl Z)", session.undo).mark("undo")
    redo = _step_button("redo", "redo (Ctrl Y)", session.redo).mark("redo")
    with _icon("history", "all steps", lambda: None).mark("history"), ui.menu().classes("min-w-64") as steps:
        pass

    def list_steps() -> None:
        steps.clear()
        with steps:
            for at, step in enumerate(session.history.steps):
                item = ui.menu_item(step.name, lambda at=at: session.move_to(at))
                item.classes("" if at <= session.history.at else "opacity-50")
                item.props("active" if at == session.history.at else "")

    def show() -> None:
        history = session.history
        for button, name in ((undo, history.undoes), (redo, history.redoes)):
            button.set_text(_short(name))
            button.set_enabled(bool(name))

    steps.on("before-show", list_steps)
    follow(session, undo, lambda *_: in_loop(undo, show, PICTURE_FIRST_S))
    show()


def _step_button(icon: str, does: str, clicked: Callable[[], None]) -> Button:
    button = ui.button(icon=icon, on_click=lambda: clicked())
    button.props("flat dense no-caps no-wrap color=white")  # a header that grew would move the page
    return tip(button, does)


class _Menus:
    """The tabs and what belongs to each, built when it is opened for the first time."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.shown = [menu for menu in MENUS if importlib.util.find_spec(menu.module) is not None]
        wanted = _open_menu.get(session, MENUS[FIRST_MENU[session.state.data.kind]].name)
        names = [menu.name for menu in self.shown]
        self._first = wanted if wanted in names else next(iter(names), "")
        self._panels: dict[str, _Place] = {}
        self._built: set[str] = set()

    def build_tabs(self) -> None:
        """Build the row of tabs."""
        self._tabs = ui.tabs(on_change=lambda event: self.open(event.value)).on("update:model-value", js_handler=ANSWER)
        self._tabs.props("dense no-caps inline-label align=left").classes("w-full")
        with self._tabs:
            for menu in self.shown:
                ui.tab(menu.name, icon=menu.icon).mark(menu.name)

    def build_panels(self) -> None:
        """Build a place for each menu, and the first of them."""
        self._place = ui.column().classes("w-full gap-0 p-2").props(f'id=menus data-shown="{self._first}"')
        with self._place:
            if not self.shown:
                ui.label("There are no menus.")
            for menu in self.shown:
                panel = self._panels[menu.name] = _Place().classes("w-full gap-2").props(f'data-menu="{menu.name}"')
                panel.set_visibility(False)
                with panel, ui.row().classes("items-center p-4"):
                    ui.spinner()
                    ui.label(f"opening {menu.name} ...")
        self._tabs.set_value(self._first)

    def choose(self, number: int) -> None:
        """Open the tab with this number, from 1 on, if there is one."""
        if 1 <= number <= len(self.shown):
            name = self.shown[number - 1].name
            self._tabs.set_value(name)
            self._place.client.run_javascript(f'document.getElementById("menus").dataset.shown = "{name}"')

    def open(self, name: str) -> None:
        """Show one menu and hide the others."""
        _open_menu[self._session] = name
        for other, panel in self._panels.items():
            panel.set_visibility(other == name)
        for menu in self.shown:
            if menu.name == name and name not in self._built:
                self._build(menu)

    def _build(self, menu: Menu) -> None:
        """Build the first menu; one that is opened later soon, so that the loop first does what waits."""
        panel, is_first = self._panels[menu.name], not self._built
        self._built.add(menu.name)

        async def fill() -> None:
            with contextlib.suppress(Exception):  # it gets the state when it is built
                await run.io_bound(importlib.import_module, menu.module)
            if self._tabs.value == menu.name:
                self._fill(menu, panel)
            else:  # by now another is wanted
                self._built.discard(menu.name)

        if is_first:
            self._fill(menu, panel)
        else:
            with panel:
                ui.timer(0.0, fill, once=True)

    def _fill(self, menu: Menu, panel: ui.column) -> None:
        panel.clear()
        try:
            with panel:
                importlib.import_module(menu.module).build(self._session)
        except Exception as error:  # one menu that fails does not take the others away
            log.error("%s: %s", menu.name, one_line(error), exc_info=log.isEnabledFor(logging.DEBUG))
            panel.clear()
            with panel:
                ui.label(f"{menu.name} cannot be shown: {one_line(error)}").classes("text-negative p-4")


class _Keys:
    """What keys do on every menu, and the overlay that lists them."""

    def __init__(self, session: Session, menus: _Menus, opens: OpenDialog) -> None:
        self._session, self._menus, self._opens = session, menus, opens
        with ui.dialog() as self._overlay, ui.card():
            ui.label("Keys").classes("text-lg")
            self._list = ui.grid(columns="auto auto").classes("gap-x-6 gap-y-1")
        ui.keyboard(self._pressed, repeating=False, ignore=["input", "select", "textarea"])

    def show(self) -> None:
        """Show the keys of the frame and of the menus that are loaded."""
        self._list.clear()
        with self._list:
            for keys, what in (*KEYS, *_keys_of(self._menus.shown)):
                ui.label(keys).classes("font-mono")
                ui.label(what)
        self._overlay.open()

    def toggle_dark(self) -> None:
        """Dark to light and back."""
        self._session.do(SetView("dark", not self._session.state.view.dark))

    def toggle_presentation(self) -> None:
        """Fan to beams beside each other and back."""
        fan = self._session.state.view.presentation == "fan"
        self._session.do(SetView("presentation", "polar" if fan else "fan"))

    def _pressed(self, event: KeyEventArguments) -> None:
        if not event.action.keydown:
            return
        key, pressed = event.key.name, event.modifiers
        if pressed.ctrl or pressed.meta:
            self._step(key.lower(), pressed.shift)
        elif key.isdecimal():
            self._menus.choose(int(key))
        else:
            keys = {"?": self.show, "o": self._opens.open, "p": self.toggle_presentation, "d": self.toggle_dark}
            does = keys.get(key.lower())
            if does and not pressed.alt:
                does()

    def _step(self, key: str, shift: bool) -> None:
        if key == "y" or (key == "z" and shift):
            self._session.redo()
        elif key == "z":
            self._session.undo()


def _keys_of(menus: list[Menu]) -> list[tuple[str, str]]:
    """Return the KEYS of the menus' modules; they are all imported for it."""
    return [row for menu in menus for row in getattr(importlib.import_module(menu.module), "KEYS", ())]
