"""Menu "Echogram": range against ping, a whole mission at once, with what was found and where images say nothing."""

from functools import partial
from typing import NamedTuple, get_args, get_type_hints
from weakref import WeakKeyDictionary

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from ods.base.errors import one_line
from ods.workbench.engine.background.newest import Newest
from ods.workbench.engine.echogram import run as echogram_run
from ods.workbench.engine.echogram.layers import Layers, layers_of
from ods.workbench.engine.echogram.levels import Echogram, title_of
from ods.workbench.engine.echogram.run import EchogramRun
from ods.workbench.engine.mission import rerun
from ods.workbench.engine.mission.tracked import Tracked
from ods.workbench.model.actions import SetView, ShowPing
from ods.workbench.model.state import EchogramLayer, State, View
from ods.workbench.pages.observer import TRACKED, tracking_progress
from ods.workbench.pages.parts.reruns import rerun_of
from ods.workbench.pages.parts.tips import tip
from ods.workbench.session import Session
from ods.workbench.web.follow import follow, in_loop
from ods.workbench.web.frames import wake
from ods.workbench.web.views.echogram_view import EchogramPicture, EchogramView, picture_of

VIEW = "echogram"
HEIGHT = "calc(100vh - 9.5rem)"
PALETTES = get_args(get_type_hints(View)["palette"])
LAYERS: dict[EchogramLayer, tuple[str, str]] = {
    "echoes": ("detections", "of configuration A"),
    "tracks": ("tracks", "ranges of tracked objects in the fan, by their states"),
    "truth": ("truth", "ranges of true objects in the fan, where they are known"),
    "faults": ("drop-outs", "unobserved images or parts of them, and missing pings"),
    "validity": ("validity", "lists that are not valid"),
}
"""Name and meaning of each."""

_runs: "WeakKeyDictionary[Session, EchogramRun]" = WeakKeyDictionary()


def echogram_of(session: Session) -> EchogramRun:
    """Return what reads a session's echograms: what it has outlives the page."""
    if session not in _runs:
        _runs[session] = EchogramRun(session.folders)
    return _runs[session]


def build(session: Session) -> None:
    """Build the menu."""
    _Page(session)


class _Wish(NamedTuple):
    """Layers of an echogram; all three are compared as objects."""

    result: Tracked
    echogram: Echogram
    beam: int | None


class _Page:
    """Widgets of one page; the source of its view's pictures."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._run, self._rerun = echogram_of(session), rerun_of(session)
        self._picture: tuple[Echogram, EchogramPicture] | None = None
        self._shown = True
        self._layers: Newest[_Wish, Layers] = Newest(
            lambda wish: layers_of(*wish), lambda _, made: self._show_layers(made), self._failed
        )
        panel = ui.context.slot.parent
        self._build()
        client = panel.client
        client.on_delete(self._layers.close)
        client.on_delete(self._run.listen(self._came))
        client.on_delete(self._rerun.listen(lambda: in_loop(self._view, self._tracked)))
        follow(session, self._view, self._changed)
        panel.bind_visibility_to(self, "is_shown")
        self._ask()
        self._came()
        self._tracked()

    def _build(self) -> None:
        with ui.row().classes("w-full items-center gap-3"):
            self._beam = ui.number("beam", min=0, precision=0, placeholder="all: the highest", on_change=self._set_beam)
            self._beam.props("dense clearable stack-label debounce=400").classes("w-36").mark("echogram beam")
            self._switches = {
                layer: ui.checkbox(name, on_change=partial(self._switch, layer))
                .props("dense")
                .tooltip(meaning)
                .mark(layer)
                for layer, (name, meaning) in LAYERS.items()
            }
            for switch in self._switches.values():
                switch.props("dense")
            ui.label("colours, dB").classes("text-xs opacity-80 ml-2")
            self._scale = ui.range(min=-20, max=60, step=1, on_change=self._set_scale).props("dense label")
            self._scale.classes("w-28").tooltip("colour scale, dB over the echogram's median")
            self._palette = ui.select(list(PALETTES), on_change=lambda event: self._set("palette", event.value))
            tip(self._palette.props("dense options-dense borderless"), "colours of all images")
            ui.space()
            self._status = ui.label().classes("text-sm opacity-80").mark("echogram-status")
        self._view = EchogramView(self._session, self, VIEW, height=HEIGHT)
        self._view.on_pick(lambda place: self._session.do(ShowPing(place)))
        self._arrange(self._session.state)

    # -- what the user does --
    def _set(self, name: str, value: object) -> None:
        if getattr(self._session.state.view, name) != value:
            self._session.do(SetView(name, value))

    def _set_beam(self, event: ValueChangeEventArguments[float | None]) -> None:
        self._set("echogram_beam", None if event.value is None else max(0, int(event.value)))

    def _switch(self, layer: EchogramLayer, event: ValueChangeEventArguments[bool]) -> None:
        shown = self._session.state.view.echogram_layers
        if event.value != (layer in shown):
            wanted = {*shown, layer} if event.value else {*shown} - {layer}
            self._set("echogram_layers", tuple(each for each in LAYERS if each in wanted))

    def _set_scale(self) -> None:
        low, high = float(self._scale.value["min"]), float(self._scale.value["max"])
        if low < high:
            first, second = ("lowest_db", low), ("highest_db", high)
            for name, value in (first, second) if low < self._session.state.view.highest_db else (second, first):
                self._set(name, value)

    # -- what is asked for --
    @property
    def is_shown(self) -> bool:
        """Whether the menu is open: only then anything is read and tracked."""
        return self._shown

    @is_shown.setter
    def is_shown(self, shown: bool) -> None:
        came, self._shown = shown and not self._shown, shown
        if came:
            self._ask()

    def _ask(self) -> None:
        state = self._session.state
        if self._shown and state.data.kind in TRACKED:
            self._run.ask(echogram_run.wanted(state))
            self._rerun.ask(rerun.wanted(state))

    def _changed(self, before: State, after: State) -> None:
        self._ask()
        if before.view != after.view:
            self._arrange(after)
        if echogram_run.wanted(before) != echogram_run.wanted(after) or rerun.wanted(before) != rerun.wanted(after):
            self._tracked()

    def _arrange(self, state: State) -> None:
        """Let the tools show what the state says."""
        view = state.view
        self._beam.set_value(view.echogram_beam)
        for layer, switch in self._switches.items():
            switch.set_value(layer in view.echogram_layers)
        self._scale.set_value({"min": max(view.lowest_db, -20.0), "max": min(view.highest_db, 60.0)})
        self._palette.set_value(view.palette)

    # -- what comes of it --
    def latest(self, view: str) -> EchogramPicture | None:
        """Return the view's newest picture."""
        return None if self._picture is None else self._picture[1]

    def _came(self) -> None:
        """Make a picture of what was read, in the thread that read it."""
        echogram = self._run.result
        if echogram is not None and (self._picture is None or self._picture[0] is not echogram):
            self._picture = echogram, picture_of(echogram)
            wake()
        in_loop(self._view, self._tracked)

    def _tracked(self) -> None:
        """Show how far all is, and ask for the layers of what is there."""
        state, run, result = self._session.state, self._run, self._rerun.result
        wish = echogram_run.wanted(state)
        echogram = run.result if run.result_of == wish else None
        of, other_settings = self._rerun.result_of, ""
        if echogram is None or result is None or of is None or of[:2] != wish[:2]:
            self._view.show_layers(Layers())
        else:
            self._layers.ask(_Wish(result, echogram, wish.beam))
            other_settings = "" if of == rerun.wanted(state) else "detections and tracks of other settings"
        self._view.set_title("Echogram" if echogram is None else title_of(echogram, wish.beam))
        self._view.set_busy(other_settings or ("" if echogram is not None or run.result is None else "not the newest"))
        self._status.set_text(self._doing(state, echogram, tracks_are_old=of != rerun.wanted(state)))
        self._status.classes(replace=f"text-sm {'text-negative' if run.error else 'opacity-80'}")

    def _doing(self, state: State, echogram: Echogram | None, *, tracks_are_old: bool) -> str:
        if state.data.kind not in TRACKED:
            return "No data are open. The echogram of a recording or scene is shown here."
        if self._run.error:
            return self._run.error
        words = []
        if not self._run.is_whole:
            words.append("opening the data ..." if echogram is None else f"read: {echogram.read} of {echogram.pings}")
        if self._rerun.error:
            words.append(f"no detections and tracks: {self._rerun.error}")
        elif tracks_are_old:
            words.append(tracking_progress(self._rerun.progress))
        return "; ".join(dict.fromkeys(words))

    def _failed(self, _: _Wish, error: Exception) -> None:
        in_loop(self._view, partial(self._status.set_text, f"no layers: {one_line(error)}"))

    def _show_layers(self, made: Layers) -> None:
        in_loop(self._view, partial(self._view.show_layers, made))
