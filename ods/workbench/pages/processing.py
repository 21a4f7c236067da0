"""Menu 1, image processing: the chain and its sliders beside what they do to a ping, at once."""

from functools import partial

from nicegui import ui
from nicegui.events import KeyEventArguments

from ods.workbench.engine.data import Data
from ods.workbench.engine.mission.moments import Moments, moments_of
from ods.workbench.engine.ping.thresholds import setting_at
from ods.workbench.model import actions as do
from ods.workbench.model.paths import PathError
from ods.workbench.model.state import State
from ods.workbench.pages.parts.timeline import Timeline
from ods.workbench.pages.ping.charts import CostBars, Histogram, Profile
from ods.workbench.pages.ping.labelling import Labelling
from ods.workbench.pages.ping.pictures import BESIDE, MAIN, OTHER, compares, counts_of, frames_of, reading, titles_of
from ods.workbench.pages.ping.stages import StageList
from ods.workbench.pages.ping.tools import Tools
from ods.workbench.pages.ping.work import Answer, Costs, Work, last_stage
from ods.workbench.session import Session
from ods.workbench.web.follow import follow, in_loop
from ods.workbench.web.frames import FrameBoard
from ods.workbench.web.views.fan_view import FanView, Spot

KEYS = (
    ("drag", "in a profile or histogram: a level of the detector"),
    ("F", "image processing: pictures fill the window, and back"),
    ("L", "image processing: draw labels in a recording, and no more"),
    ("space", "image processing: play, and stop"),
    ("arrows, with Shift", "image processing: a ping back or on, ten"),
    ("N, Shift N", "image processing: to the next mark of the timeline, to the one before"),
)
PICTURES = "processing-pictures"
"""Id of their row, which goes full screen."""
HEIGHT = "42vh"
"""Of a picture with charts below it."""
WINDOW = "calc(100vh - 7rem)"
"""Height below the header."""
BLINK_S = 0.6
BUSY_S = 0.25
"""A picture that is older is dimmed."""
BESIDE_S, BESIDE_HELD_S = 0.1, 0.4
"""After the picture, which the browser then has drawn, what is beside it is sent: no more often while one drags a
slider, or the timeline, as it costs the browser more than the picture."""


def build(session: Session) -> None:
    """Build the menu in the current slot."""
    _Page(session)


class _Page:
    """Widgets of one page, and the thread that works for them."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._board = FrameBoard()
        self._answer: Answer | None = None
        self._moments: tuple[Data, Moments] | None = None
        panel = ui.context.slot.parent
        self._waits: Answer | None = None
        self._work = Work(session, self)
        with ui.splitter(value=0, limits=(0, 900)).props("unit=px").classes("w-full") as self._root:
            self._root.on("update:model-value", self._set_width)  # by the user only
            with self._root.before:
                self._column = ui.column().classes("w-full gap-1 overflow-y-auto pr-2").style(f"max-height: {WINDOW}")
            with self._column:
                self._stages = StageList(session)
            with self._root.after, ui.column().classes("w-full min-w-0 gap-1 flex-nowrap pl-2") as self._right:
                self._tools = Tools(session, lambda: self._labelling.toggle(), PICTURES)
                self._build_pictures()
                self._timeline = Timeline(session, lambda: self._work.answered == self._work.asked, self._hold)
                ui.keyboard(self._pressed, ignore=["input", "select", "textarea", "button"])
                with ui.column().classes("w-full gap-1") as self._charts:
                    self._build_charts()
        panel.bind_visibility_to(self._work, "visible")
        ui.context.client.on_delete(self._work.close)
        ui.timer(0.1, self._mark_busy)
        self._blinks = ui.timer(BLINK_S, self._blink, active=False)
        follow(session, self._root, self._follow)
        self._arrange(session.state)
        self._work.ask()

    # -- building --
    def _build_charts(self) -> None:
        with ui.row().classes("w-full no-wrap items-start gap-3"):
            with ui.column().classes("w-1/2 min-w-0 gap-0"):
                self._profile = Profile(self._drag_level)
            with ui.column().classes("w-1/2 min-w-0 gap-0"):
                self._histogram = Histogram(self._drag_level)
        self._cost = CostBars()

    def _build_pictures(self) -> None:
        tools = ui.element("div").classes("w-full")
        self._complaint = ui.label().classes("text-negative text-sm").mark("trouble")
        ui.add_css(f"#{PICTURES}:fullscreen > * {{ height: 100% !important; }}")  # after the picture's own style
        with ui.row().classes("w-full no-wrap gap-2 grow min-h-0").props(f"id={PICTURES}"):
            self._main = FanView(self._session, self._board, MAIN, height=HEIGHT).classes("grow min-w-0")
            self._second = FanView(self._session, self._board, BESIDE, height=HEIGHT).classes("grow min-w-0")
        for view in (self._main, self._second):
            view.on_hover(self._hover)
            view.on_pick(self._pick)
        with tools:
            self._labelling = Labelling(self._session, (self._main, self._second))
        self._readout = ui.label("point at a picture: range, bearing and level").classes("text-xs opacity-80")

    # -- what the user does --
    def _set_width(self) -> None:
        """Keep the width that the user drags, also if the pictures have the window by then; a quick one has none."""
        if self._root.value:
            self._tools.set("chain_px", int(min(max(self._root.value, 280), 900)))
        view = self._session.state.view
        self._root.set_value(0 if view.large else view.chain_px)

    def _pressed(self, event: KeyEventArguments) -> None:
        if event.action.keydown and self._work.visible:
            self._timeline.press(event)
            does = {"f": self._tools.toggle_large, "l": self._labelling.toggle}.get(event.key.name.lower())
            if does and not (event.modifiers.ctrl or event.modifiers.meta or event.modifiers.alt):
                does()

    def _hold(self, held: bool) -> None:
        self._work.hold(held)
        if not held:
            self._show_newest()

    def _drag_level(self, name: str, level_db: float) -> None:
        if self._answer is None:
            return
        tuning = self._answer.state.tuning
        place, stage = last_stage(tuning)
        value = setting_at(self._answer.a.looks[-1], stage, level_db)
        if value is not None:
            try:
                self._session.do(do.SetSetting(f"pipeline.stage[{place}].{name}", value))
            except PathError as error:
                self._complaint.set_text(str(error))

    def _hover(self, spot: Spot) -> None:
        if self._session.state.view.pinned_beam is None:
            self._profile.beam(spot.beam)
        self._readout.set_text(reading(self._answer, spot))

    def _pick(self, spot: Spot) -> None:
        pinned = self._session.state.view.pinned_beam
        self._session.do(do.SetView("pinned_beam", None if pinned == spot.beam else spot.beam))

    # -- what comes of it --
    def answered_with(self, answer: Answer) -> None:
        """Take an answer, in the thread of the work: the picture first, then what is beside it."""
        for name, frame in frames_of(answer).items():
            self._board.show(name, frame)
        in_loop(self._root, partial(self._take, answer))

    def costed(self, costs: Costs, period_s: float | None) -> None:
        """Take what the chains cost."""
        in_loop(self._root, partial(self._cost.show, costs, period_s))

    def failed(self, why: str) -> None:
        """Take why nothing came."""

        def show() -> None:
            self._show_newest()  # of what came before
            self._complaint.set_text(why)
            self._mark_busy()

        in_loop(self._root, show)

    def _take(self, answer: Answer) -> None:
        if self._waits is None:
            in_loop(self._root, self._show_newest, BESIDE_HELD_S if self._work.held else BESIDE_S)
        self._waits = answer

    def _show_newest(self) -> None:
        answer, self._waits = self._waits, None
        if answer is not None:
            self._show(answer)

    def _show(self, answer: Answer) -> None:
        self._answer = answer
        self._complaint.set_text(answer.complaint)
        self._mark_busy()
        self._profile.answer(answer)
        self._histogram.answer(answer)
        if self._moments is None or self._moments[0] is not answer.data:
            self._moments = answer.data, moments_of(answer.data)
        self._timeline.show(self._moments[1], answer.place)
        self._stages.show_spacing(answer.a.ping.dr_m)
        whose = "your labels" if answer.data.truth(answer.place) is None else "the truth"
        self._stages.show_counts("" if answer.judged_a is None else f"against {whose}: {counts_of(answer.judged_a)}")
        for picture, title in zip((self._main, self._second), titles_of(answer), strict=True):
            picture.set_title(title)

    def _mark_busy(self) -> None:
        """Dim pictures that are not the newest, with the reason."""
        busy = self._work.is_late(BUSY_S)
        old = self._complaint.text and self._answer is not None
        why = "computing" if busy else old and "not the newest"
        for view in (self._main, self._second):
            view.set_busy(why or "")

    def _blink(self) -> None:
        self._main.switch(OTHER if self._main.view == MAIN else MAIN)

    def _follow(self, before: State, after: State) -> None:
        if _arranged(before) != _arranged(after):
            self._arrange(after)

    def _arrange(self, state: State) -> None:
        """Show what the state says: tools, and which pictures there are."""
        view = state.view
        self._tools.arrange(state)
        self._column.set_visibility(not view.large)
        self._root.set_value(0 if view.large else view.chain_px)
        self._charts.set_visibility(not view.large)
        for picture in (self._main, self._second):
            picture.style(f"height: {'100%' if view.large else HEIGHT}")
        self._right.style(f"height: {WINDOW if view.large else 'auto'}")
        self._second.set_visibility(compares(state) or view.compared_stage is not None or state.beside is not None)
        self._blinks.active = state.other is not None and view.comparison == "blink"
        if not self._blinks.active and self._main.view != MAIN:
            self._main.switch(MAIN)
        if view.pinned_beam is not None:
            self._profile.beam(view.pinned_beam)


def _arranged(state: State) -> tuple[object, ...]:
    return state.view, state.tuning, state.other, state.further, state.beside
