"""Menu 3, Simulator: a scene edited in its plan and seen at once; the mission rehearsed."""

import math
from collections.abc import Callable
from pathlib import Path

from nicegui import ui

from ods.base.errors import one_line
from ods.workbench.engine.background.newest import Newest
from ods.workbench.engine.background.own_process import OwnProcess, whole
from ods.workbench.engine.scene.rehearsal import Rehearsal
from ods.workbench.engine.scene.view import Asked, Pictured, pictured, pings_of
from ods.workbench.model import actions as do
from ods.workbench.model.scene.handles import Handle, dragged, handles_of
from ods.workbench.model.state import State
from ods.workbench.pages.scene.charts import show_profile, show_strip
from ods.workbench.pages.scene.opening import open_bar
from ods.workbench.pages.scene.panels import try_to
from ods.workbench.pages.scene.shapes import handle_shapes, plan_shapes, rehearsed_shapes
from ods.workbench.pages.scene.side import VEHICLE, Side
from ods.workbench.pages.scene.tools import PLAN, PlanTools
from ods.workbench.session import Session
from ods.workbench.web.follow import follow, in_loop
from ods.workbench.web.frames import Circle, Frame, FrameBoard, cells_of
from ods.workbench.web.views.chart_view import ChartView
from ods.workbench.web.views.fan_view import FanView, Spot as FanSpot
from ods.workbench.web.views.plan_view import Drag, Pick, PlanView

IMAGE = "scene"
SCALE_DB = (-30.0, 60.0)
"""Levels over the median that the image can show."""
NEAR_M = 3.0
"""Distance from a handle within which a click selects its object."""


def build(session: Session) -> None:
    """Build the menu, and again when another scene is opened."""
    _Menu(session)


class _Menu:
    """What opens a scene, and with one open the simulator, which simulates while the menu is shown."""

    def __init__(self, session: Session) -> None:
        self._session, self._visible = session, True
        self._simulator: _Simulator | None = None
        self._process = OwnProcess(pictured, nicer=0)
        self._newest: Newest[tuple[_Simulator, Asked], Pictured] = Newest(
            self._picture, lambda wish, shown: wish[0].show(shown), lambda wish, error: wish[0].failed(error),
            idle=self._process.end,
        )  # fmt: skip
        panel = ui.context.slot.parent
        self._place = ui.column().classes("w-full gap-1")
        panel.bind_visibility_to(self, "visible")
        panel.client.on_delete(self._newest.close)
        follow(session, self._place, self._changed)
        self._fill()

    @property
    def visible(self) -> bool:
        """Whether the menu is seen."""
        return self._visible

    @visible.setter
    def visible(self, seen: bool) -> None:
        self._visible = seen
        if self._simulator is not None:
            self._simulator.see(seen)

    def _fill(self) -> None:
        self._place.clear()
        self._simulator = None
        with self._place:
            open_bar(self._session)
            if self._session.state.scene is not None:
                self._simulator = _Simulator(self._session, self._visible, self._newest.ask)

    def _picture(self, wish: "tuple[_Simulator, Asked]") -> Pictured:
        return self._process(whole, wish[1])

    def _changed(self, before: State, after: State) -> None:
        if (before.data, before.scene is None) != (after.data, after.scene is None):
            self._fill()


class _Simulator:
    """The menu with a scene open."""

    def __init__(self, session: Session, seen: bool, picture: "Callable[[tuple[_Simulator, Asked]], None]") -> None:
        """picture: asks for one, for `show` of the simulator named."""
        self._session, self._picture = session, picture
        self._seen, self._waits = seen, False
        self._board = FrameBoard()
        self._shown: Pictured | None = None
        self._selected = VEHICLE
        with ui.row().classes("w-full no-wrap items-start gap-3"):
            with ui.column().classes("gap-1 min-w-0").style("width: 38%"):
                self._build_plan()
            with ui.column().classes("gap-1 min-w-0").style("width: 36%"):
                self._build_image()
            with ui.column().classes("gap-1 min-w-0").style("width: 26%; min-width: 21.5rem"):
                self._side = Side(session, self._select, self._show_rehearsal)
        follow(session, self._fan, self._changed)
        self._ask(session.state)
        self._draw_handles(session.state)

    def _build_plan(self) -> None:
        tools = ui.element().classes("w-full")
        self._plan = PlanView(title=PLAN, height="56vh", follows=True)
        self._plan.on_drag(self._drag)
        self._plan.on_pick(self._pick)
        with tools:
            self._tools = PlanTools(self._session, self._plan, lambda: self._selected, self._select)
        self._strip = ChartView(height="max(22vh, 11rem)")

    def _build_image(self) -> None:
        self._fan = FanView(self._session, self._board, IMAGE, title="the ping", height="46vh")
        self._fan.on_pick(self._pin)
        self._fan.set_limits(_limits(self._session.state))
        with ui.row().classes("w-full items-center no-wrap gap-3"):
            self._time = ui.slider(min=0, max=1, value=self._session.state.ping).mark("ping")
            self._time.on_value_change(lambda event: self._session.do(do.ShowPing(int(event.value))))
            self._clock = ui.label().classes("text-sm w-40 shrink-0").mark("clock")
        self._profile = ChartView(height="max(30vh, 13rem)")

    def see(self, seen: bool) -> None:
        """Take whether the menu is shown: while it is not, nothing is simulated."""
        self._seen = seen
        if seen and self._waits:
            self._ask(self._session.state)

    def _ask(self, state: State) -> None:
        self._waits = not self._seen
        if self._seen and state.scene is not None:
            path = Path(state.data.path) if state.data.kind == "scene" and state.data.path else None
            self._picture((self, Asked(state.scene, state.data.sonar, state.ping, path)))

    def _changed(self, before: State, after: State) -> None:
        now = self._session.state  # newer than `after`, perhaps
        if now.scene is None:
            return
        if (before.scene, before.ping) != (after.scene, after.ping):
            self._ask(now)
            self._draw_handles(now)
        if _parts(before) != _parts(after):
            self._select(self._selected if self._selected in _parts(now) else VEHICLE)
        self._fan.set_limits(_limits(now))
        if before.view.pinned_beam != after.view.pinned_beam and self._shown is not None:
            self._draw_profile(self._shown)

    def show(self, shown: Pictured) -> None:
        """Take an image, in the thread that asked for it."""
        self._board.show(IMAGE, _frame(shown))
        in_loop(self._fan, lambda: self._show(shown))

    def failed(self, error: Exception) -> None:
        """Take why there is none, in that thread."""
        in_loop(self._fan, lambda: self._fan.set_busy(one_line(error)))

    def _show(self, shown: Pictured) -> None:
        first, self._shown = self._shown is None, shown
        self._fan.set_busy("")
        last = pings_of(shown.asked.file, shown.sonar) - 1
        self._time.props(f"max={last}")
        self._time.set_value(min(self._session.state.ping, last))
        self._clock.set_text(f"ping {shown.ping.ping_number} of {last}, {shown.t_s:.1f} s")
        self._plan.show("scene", plan_shapes(shown.plan, self._selected))
        self._tools.moment = shown
        self._draw_handles(self._session.state)
        self._draw_profile(shown)
        show_strip(self._strip, shown, self._selected)
        if first:
            self._plan.fit()
            self._side.show_sonar(shown.sonar)

    def _draw_handles(self, state: State) -> None:
        if state.scene is not None:
            self._plan.show("handles", handle_shapes(handles_of(state.scene, self._t_s), self._selected))

    def _draw_profile(self, shown: Pictured) -> None:
        show_profile(self._profile, shown, self._beam(shown))

    def _show_rehearsal(self, result: Rehearsal | None) -> None:
        self._plan.show("rehearsed", rehearsed_shapes(result))

    def _beam(self, shown: Pictured) -> int:
        middle = len(shown.sonar.plane_bearing_rad) // 2
        pinned = self._session.state.view.pinned_beam
        return middle if pinned is None or pinned >= 2 * middle else pinned

    @property
    def _t_s(self) -> float:
        return self._shown.t_s if self._shown is not None else 0.0

    def _select(self, part: str) -> None:
        self._selected = part
        self._side.show(part)
        self._draw_handles(self._session.state)
        if self._shown is not None:
            self._plan.show("scene", plan_shapes(self._shown.plan, part))
            show_strip(self._strip, self._shown, part)

    def _pick(self, pick: Pick) -> None:
        scene = self._session.state.scene
        if scene is not None and not self._tools.put(pick.place):
            self._select(_nearest(handles_of(scene, self._t_s), pick.place) or self._selected)

    def _pin(self, spot: FanSpot) -> None:
        self._session.do(do.SetView("pinned_beam", spot.beam))

    def _drag(self, drag: Drag) -> None:
        scene = self._session.state.scene
        if scene is None:
            return
        if (part := drag.id.partition(".")[0]) != self._selected:
            self._select(part)
        try_to(self._session, dragged(scene, drag.id, drag.place, self._t_s, self._tools.step_m))


def _limits(state: State) -> tuple[float, float]:
    return state.view.lowest_db, state.view.highest_db


def _parts(state: State) -> list[str]:
    """Return what can be selected."""
    count = len(state.scene.objects) if state.scene is not None else 0
    return [VEHICLE, *(f"objects[{place}]" for place in range(count))]


def _nearest(handles: list[Handle], place: tuple[float, float]) -> str:
    near = [(math.hypot(each.at[0] - place[0], each.at[1] - place[1]), each.path.partition(".")[0]) for each in handles]
    distance, part = min(near)
    return part if distance <= NEAR_M else ""


def _frame(shown: Pictured) -> Frame:
    ping = shown.ping
    return Frame(
        cells_of(shown.fan_db, SCALE_DB),
        shown.sonar.plane_bearing_rad,
        ping.range0_m,
        ping.dr_m,
        SCALE_DB,
        tuple(Circle(*circle, "truth") for circle in shown.truth_circles()),
        caption=f"{shown.t_s:.2f} s, dB over the median; circles: truth",
    )
