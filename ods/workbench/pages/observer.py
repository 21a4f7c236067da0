"""Menu "Observer": the mission tracked again as settings move; plan, courses over time, lives, static objects."""

import numpy as np
from nicegui import ui
from nicegui.events import KeyEventArguments

from ods.offline.score import position_rms_m
from ods.workbench.engine.mission.moments import Moments, moments_of_mission
from ods.workbench.engine.mission.rerun import Progress, Rerun, wanted
from ods.workbench.engine.mission.tracked import Tracked, track_name
from ods.workbench.model.actions import SetView, ShowPing
from ods.workbench.model.state import DataReference, State
from ods.workbench.pages.mission import plan as observer_plan, times as observer_times
from ods.workbench.pages.mission.scene import NOT_KNOWN, SceneDialog, heights_known
from ods.workbench.pages.mission.settings import settings_panel
from ods.workbench.pages.parts.reruns import rerun_of
from ods.workbench.pages.parts.tables import NUMBERS, Columns, numbers, place, table
from ods.workbench.pages.parts.timeline import Timeline
from ods.workbench.session import Session
from ods.workbench.web.follow import follow, in_loop
from ods.workbench.web.views.chart_view import Axis, ChartView
from ods.workbench.web.views.plan_view import Pick, PlanView

KEYS = (("click", "in the plan or in a strip: mark an object; in a diagram: go to that time"),)
AT_REST: Columns = (
    ("name", "track"), ("north", "north, m"), ("east", "east, m"), ("down", "down, m"), ("radius", "radius, m"),
    ("exists", "exists"), ("seen", "seen"),
)  # fmt: skip
SCORES: Columns = (
    ("name", "object"), ("tracked", "tracked"), ("rms", "position error, m rms"), ("radius", "radius error"),
    ("ids", "tracks"),
)  # fmt: skip
TRACKED = ("file", "scene")
"""Kinds of data that can be tracked again."""
COMPUTING = "computing ..."
TABLE_S = 0.25
"""The table of a ping follows plan and diagrams, which cost the browser less."""
HEIGHT = "max(100vh - 370px, 33rem)"
"""At least what 12 strips and the courses below them need."""


def build(session: Session) -> None:
    """Build the menu."""
    _Observer(session, rerun_of(session))


class _Observer:
    """The page's widgets, and what keeps them up to date."""

    def __init__(self, session: Session, rerun: Rerun) -> None:
        self._session, self._rerun = session, rerun
        self._drawn: Tracked | None = None
        self._moments: Moments | None = None
        """Of what is drawn."""
        self._shown = True
        self._table_waits = False
        panel = ui.context.slot.parent
        with ui.row().classes("w-full no-wrap items-start gap-2"):
            with (
                ui.column()
                .classes("gap-1 overflow-auto shrink-0")
                .style(f"width: 385px; max-height: calc({HEIGHT} + 220px)")
            ):
                settings_panel(session)
            with ui.column().classes("gap-1 grow min-w-0"):
                self._build_views()
        follow(session, self._plan, self._changed)
        panel.client.on_delete(rerun.listen(lambda: in_loop(self._plan, self._received)))
        panel.bind_visibility_to(self, "is_shown")
        self._ask()
        self._received()

    def _build_views(self) -> None:
        with ui.row().classes("w-full items-center no-wrap gap-3"):
            self._status = ui.label().classes("text-sm").mark("observer-status")
            self._bar = ui.linear_progress(0.0, show_value=False).classes("w-48").mark("observer-progress")
            self._scene = SceneDialog(lambda: self._drawn, lambda: self._session.state.ping)
            with ui.element("div").classes("ml-auto"):
                ui.tooltip("").bind_text_from(self, "scene_tip")
                self._to_scene = ui.button("3-D", icon="view_in_ar", on_click=self._scene.open)
                self._to_scene.props("dense flat no-caps no-wrap").mark("3-D").set_enabled(False)
        with ui.row().classes("w-full no-wrap gap-2"):
            with ui.element("div").classes("grow min-w-0").style("flex-basis: 46%"):
                self._plan = PlanView(title="Plan", height=HEIGHT)
            with ui.element("div").classes("grow min-w-0").style("flex-basis: 54%"):
                self._times = ChartView(title="Life cycles, and the history of one object", height=HEIGHT)
        self._plan.on_pick(self._picked)
        self._times.on_mark(self._mark)
        self._times.on_pick(self._go_to)
        self._timeline = Timeline(self._session, lambda: True, lambda _: None)
        ui.keyboard(self._pressed, ignore=["input", "select", "textarea", "button"])
        with ui.row().classes("w-full gap-2 items-start"):
            self._now = table("Tracks at this ping", NUMBERS, self._mark)
            self._rest = table("Static: objects in the map after the mission", AT_REST, self._mark)
            self._scores = table("Against the truth", SCORES, None)

    # -- what is asked for --

    @property
    def is_shown(self) -> bool:
        """Whether the menu is open: only then the mission is run again."""
        return self._shown

    @is_shown.setter
    def is_shown(self, shown: bool) -> None:
        came, self._shown = shown and not self._shown, shown
        if came:
            self._ask()
            self._draw_moment()

    @property
    def scene_tip(self) -> str:
        """What the button beside the status says."""
        return "the mission in three dimensions" if heights_known(self._drawn) else NOT_KNOWN

    def _pressed(self, event: KeyEventArguments) -> None:
        if event.action.keydown and self._shown:
            self._timeline.press(event)

    def _ask(self) -> None:
        if self._shown and self._session.state.data.kind in TRACKED:
            self._rerun.ask(wanted(self._session.state))

    def _changed(self, before: State, after: State) -> None:
        if wanted(before) != wanted(after):
            self._ask()
            self._received()
        if before.view.marked_obstacle != after.view.marked_obstacle:
            self._draw_courses()
        if before.ping != after.ping or before.view.marked_obstacle != after.view.marked_obstacle:
            self._draw_moment()

    def _picked(self, pick: Pick) -> None:
        if pick.id is not None:
            self._mark(pick.id)

    def _mark(self, identity: str) -> None:
        self._session.do(SetView("marked_obstacle", int(identity)))

    def _go_to(self, t_s: float) -> None:
        if self._drawn is not None and len(self._drawn.t_s):
            self._session.do(ShowPing(int(np.abs(self._drawn.t_s - t_s).argmin())))

    # -- what is shown --

    def _received(self) -> None:
        rerun, state = self._rerun, self._session.state
        if rerun.result is not None and rerun.result is not self._drawn:
            self._drawn, self._moments = rerun.result, moments_of_mission(rerun.result)
            self._draw_result(rerun.result)
        old = rerun.result_of != wanted(state)
        busy = tracking_progress(rerun.progress) if old and state.data.kind in TRACKED and not rerun.error else ""
        dimmed = COMPUTING if busy else "not the newest" if old and self._drawn is not None else ""
        self._plan.set_busy(dimmed)
        self._times.set_busy(dimmed)
        self._status.set_text(rerun.error or busy or _summary(state.data, self._drawn))
        self._status.classes(replace="text-sm text-negative" if rerun.error else "text-sm")
        progress = rerun.progress
        self._bar.set_visibility(progress is not None)
        self._bar.set_value(0.0 if progress is None else progress.done / max(1, progress.of))

    def _draw_result(self, result: Tracked) -> None:
        self._plan.show("ways", observer_plan.ways(result))
        self._to_scene.set_enabled(heights_known(result))
        self._rest.rows = [
            {
                "id": item.id,
                "name": result.name_of(item.id),
                **place(item.position, item.sigma),
                "down": f"{item.position[2]:.1f} ± {item.sigma[2]:.1f}",
                "radius": f"{item.radius:.1f} ± {item.sigma_radius:.1f}",
                "exists": f"{item.existence:.2f}",
                "seen": item.times_seen,
            }
            for item in result.at_rest
        ]
        self._scores.rows = [
            {
                "name": score.name,
                "tracked": f"{score.tracked_share:.0%}",
                "rms": f"{score.position_rms_m:.2f}",
                "radius": f"{score.radius_error:+.0%}",
                "ids": ", ".join(map(str, score.ids)),
            }
            for score in result.scores
        ]
        self._draw_courses()
        self._draw_moment()

    def _draw_courses(self) -> None:
        result, marked = self._drawn, self._session.state.view.marked_obstacle
        if result is None or not len(result.t_s):
            return
        course = observer_times.looked_at(result, marked)
        time = Axis("time, s", float(result.t_s[0]), float(result.t_s[-1]), cursor="time")
        which = None if course is None else course.id
        strips = observer_times.strips(result, which)
        self._times.show(time, observer_times.panels(result, course), strips, columns=2)
        title = "Lives" if which is None else f"Lives; course of {result.name_of(which)}"
        self._times.set_title(title)

    def _draw_moment(self) -> None:
        result, state = self._drawn, self._session.state
        if not self._shown or result is None or not 0 <= state.ping < len(result.t_s):
            return
        course = observer_times.looked_at(result, state.view.marked_obstacle)
        self._plan.show("moment", observer_plan.moment(result, state.ping, None if course is None else course.id))
        self._plan.set_title(f"Plan at {result.t_s[state.ping]:.1f} s, ping {state.ping}")
        self._scene.show()
        self._times.set_cursor(float(result.t_s[state.ping]))
        if self._moments is not None:
            self._timeline.show(self._moments, state.ping)
        if not self._table_waits:
            self._table_waits = True
            in_loop(self._plan, self._list_objects, TABLE_S)

    def _list_objects(self) -> None:
        self._table_waits = False
        latest = None if self._drawn is None else self._drawn.list_at(self._session.state.ping)
        name_of = track_name if self._drawn is None else self._drawn.name_of
        self._now.rows = [] if latest is None else [numbers(each, name_of(each.id)) for each in latest.obstacles]


def tracking_progress(progress: Progress | None) -> str:
    """Return in words how far a mission is tracked."""
    if progress is None or not progress.of:
        return "opening the data ..."
    what = "detecting and tracking" if progress.detects else "tracking again"
    return f"{what}: {progress.done} of {progress.of} pings"


def _summary(data: DataReference, result: Tracked | None) -> str:
    """Return one line on what is shown."""
    if data.kind == "live":
        return "A vehicle's bus cannot be tracked again: see the menu Live, or open a recording of it."
    if data.kind == "none" or result is None:
        return "No data are open: a recording with poses, or a scene, is tracked here."
    source = "simulated, truth known" if data.kind == "scene" else "recording"
    if data.kind == "file" and result.truths:
        source = "recording with truth"
    text = f"{source}: {len(result.t_s)} pings, {len(result.courses)} tracks, {len(result.at_rest)} static"
    if result.scores:
        switches = sum(max(0, len(score.ids) - 1) for score in result.scores)
        text += (
            f"; position error {position_rms_m(list(result.scores)):.2f} m rms, mean GOSPA "
            f"{np.nanmean(result.gospa_m):.2f} m, {len(result.false_ids)} false tracks, {switches} identity switches"
        )
    return text
