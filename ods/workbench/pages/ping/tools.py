"""The tool bar of image processing: which pictures are shown, their colours and size, and chains to compare with."""

from collections.abc import Callable
from typing import get_args, get_type_hints

from nicegui import ui
from nicegui.elements.select import Select

from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.model import actions as do
from ods.workbench.model.paths import typed
from ods.workbench.model.state import Beside, State, View
from ods.workbench.pages.parts.folding import folds, tool_bar
from ods.workbench.pages.parts.open_dialog import OpenDialog
from ods.workbench.pages.parts.tips import tip
from ods.workbench.pages.ping.pictures import compares, title_of
from ods.workbench.session import Session

PALETTES = get_args(get_type_hints(View)["palette"])
SHOWN = "what pictures show: attention, truth, colours"
NOTHING, OTHER_DATA = -2, -3
"""In the list of what is shown beside the picture."""
BUTTON = "dense flat no-caps no-wrap"


class Tools:
    """The bar, built in the current slot: it changes the session's state, and shows it."""

    def __init__(self, session: Session, label: Callable[[], None], full_screen: str) -> None:
        """`label` begins and ends labelling; `full_screen` is the id of the element that goes full screen."""
        self._session = session
        with tool_bar():
            self._build_choices()
            with folds("visibility", SHOWN, 1100):
                self._build_shown()
            self._build_size(label, full_screen)
            self._choose_beside = OpenDialog(session, self._put_beside)
            ui.space()
            ui.button("keep as B", on_click=lambda: session.do(do.KeepAsB())).props(BUTTON).mark("keep as B")
            with folds("compare", "B: swap, drop, how it is compared", 900) as self._with_b:
                self._build_comparison()

    # -- building --
    def _build_choices(self) -> None:
        self._after = ui.select({}, label="picture", on_change=lambda event: self.set("shown_stage", event.value))
        self._after.props("dense options-dense").classes("w-[7.5rem] max-xl:w-24").mark("shown stage")
        self._beside = ui.select({}, label="beside it", on_change=lambda event: self._show_beside(event.value))
        self._beside.props("dense options-dense").classes("w-[7.5rem] max-xl:w-24").mark("compared stage")
        ui.toggle(["fan", "polar"], on_change=lambda event: self.set("presentation", event.value)).props(
            "dense no-caps"
        ).bind_value_from(self, "presentation").tooltip("P: the other one")

    def _build_shown(self) -> None:
        self._attention = ui.checkbox("attention", on_change=lambda event: self.set("attention", event.value))
        self._attention.props("dense").tooltip("dims the ranges that this ping skips")
        self._truth = ui.checkbox("truth", on_change=lambda event: self.set("truth", event.value))
        self._truth.props("dense").mark("truth")
        self._truth.tooltip("where it is known: ✓ right, ✕ false, ? an object that was missed")
        ui.label("colours, dB").classes("text-xs opacity-80")
        self._scale = ui.range(min=-40, max=80, step=1, value={"min": -5, "max": 30}, on_change=self._set_scale)
        self._scale.props("dense label").classes("w-28").tooltip("colour scale, dB over the image's median")
        palette = ui.select(list(PALETTES), on_change=lambda event: self.set("palette", event.value))
        palette.props("dense options-dense borderless").bind_value_from(self, "palette")
        tip(palette, "colours of all images").mark("palette")

    def _build_size(self, label: Callable[[], None], full_screen: str) -> None:
        self._large = ui.button(icon="open_in_full", on_click=self.toggle_large).props("dense flat")
        tip(self._large, "pictures fill the window (F)").mark("large")
        labels = ui.button(icon="draw", on_click=label).props("dense flat")
        tip(labels, "label what is to be found in a recording (L)").mark("label")
        whole = tip(ui.button(icon="fullscreen").props("dense flat"), "full screen").mark("full screen")
        whole.on("click", js_handler=f"() => document.getElementById('{full_screen}').requestFullscreen()")

    def _build_comparison(self) -> None:
        ui.button("swap", on_click=lambda: self._session.do(do.SwapAB())).props(BUTTON).mark("swap")
        drop = ui.button("drop B", on_click=lambda: self._session.do(do.DropB())).props(BUTTON).mark("drop B")
        drop.tooltip("with C and D")
        self._next = ui.button("keep as C", on_click=lambda: self._session.do(do.KeepAsNext()))
        self._next.props(BUTTON).mark("keep as next").tooltip("for the range profile: up to four chains on one beam")
        self._comparison = ui.toggle(
            ["split", "blink", "difference"], on_change=lambda event: self.set("comparison", event.value)
        )
        self._comparison.props("dense no-caps").mark("comparison")

    # -- what the user does --
    @property
    def presentation(self) -> str:
        """Of the session; the toggle shows it."""
        return self._session.state.view.presentation

    @property
    def palette(self) -> str:
        """Of the session; the choice shows it."""
        return self._session.state.view.palette

    def set(self, name: str, value: object) -> None:
        """Set a field of the state's view, if it has another value."""
        if value is not None and getattr(self._session.state.view, name) != value:
            self._session.do(do.SetView(name, value))

    def toggle_large(self) -> None:
        """Let pictures fill the window, or no more."""
        self.set("large", not self._session.state.view.large)

    def _show_beside(self, value: int) -> None:
        state = self._session.state
        if value == OTHER_DATA:
            if state.beside is None:
                self._choose_beside.open()
                self.arrange(state)  # nothing is chosen yet
            return
        if state.beside is not None:
            self._session.do(do.ShowBeside(None))
        wanted_stage = None if value == NOTHING else value
        if state.view.compared_stage != wanted_stage:
            self._session.do(do.SetView("compared_stage", wanted_stage))

    def _put_beside(self, chosen: do.OpenData) -> None:
        scene = None if chosen.scene is None else typed(chosen.scene, SceneFile)
        self._session.do(do.ShowBeside(Beside(chosen.data, scene)))

    def _set_scale(self) -> None:
        view = self._session.state.view
        low, high = float(self._scale.value["min"]), float(self._scale.value["max"])
        if low < high and (low, high) != (view.lowest_db, view.highest_db):
            first, second = ("highest_db", high), ("lowest_db", low)
            for name, value in (first, second) if high > view.lowest_db else (second, first):
                self.set(name, value)

    # -- what the state says --
    def arrange(self, state: State) -> None:
        """Show what a state says."""
        view, chain = state.view, state.tuning.config.pipeline.chain()
        options = {place: title_of(state.tuning, place) for place in range(-1, len(chain))}
        _offer(self._after, options, min(view.shown_stage, len(chain) - 1))
        compared = NOTHING if view.compared_stage is None else min(view.compared_stage, len(chain) - 1)
        beside = {NOTHING: "nothing", **options, OTHER_DATA: "other data" if state.beside else "other data ..."}
        _offer(self._beside, beside, OTHER_DATA if state.beside else compared)
        self._beside.set_enabled(not compares(state))
        self._attention.set_value(view.attention)
        self._truth.set_value(view.truth)
        self._large.set_icon("close_fullscreen" if view.large else "open_in_full")
        self._scale.set_value({"min": view.lowest_db, "max": view.highest_db})
        self._comparison.set_value(view.comparison)
        self._with_b.set_visibility(state.other is not None)
        self._next.set_text("keep as D" if state.further else "keep as C")


def _offer(choice: Select, options: dict[int, str], value: int) -> None:
    """Give a choice its options, which are sent whole, only if they are others."""
    if (choice.options, choice.value) != (options, value):
        choice.set_options(options, value=value)
