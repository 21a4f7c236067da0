"""Menu "Live": a vehicle's own bus, read only: what it sees, what a planner receives and why, the state of its
processes, and operators' vetoes."""

from datetime import UTC, datetime
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
from nicegui import ui
from nicegui.element import Element

from ods.base import clock
from ods.base.clock import NS
from ods.base.frames.quaternion import rotated
from ods.workbench.engine.live import WORDS, Line, Live, Verdict
from ods.workbench.engine.mission.tracked import heading_of
from ods.workbench.model.actions import SetView
from ods.workbench.model.state import State
from ods.workbench.pages.mission import plan as observer_plan
from ods.workbench.pages.parts.live_image import frame_of_ping
from ods.workbench.pages.parts.live_tables import LiveTables, veto_shapes
from ods.workbench.pages.parts.tables import NUMBERS, numbers, table
from ods.workbench.session import Session
from ods.workbench.web.follow import follow, in_loop
from ods.workbench.web.frames import FrameBoard
from ods.workbench.web.views.chart_view import Axis, ChartView, Curve, Panel
from ods.workbench.web.views.fan_view import FanView
from ods.workbench.web.views.plan_view import Circle, Line as Way, Mark, Pick, PlanView, Shape

NONE = """No vehicle's bus is shown. Start the workbench with --live RUN_DIR, on the vehicle's computer or where
`ods replay --live` plays a recording."""
SHOWN_LINES = 100
HEIGHT = "max(300px, calc(100vh - 520px))"
DETECTS_S = 1.0
"""A pipeline that reported so lately has the ping's detections soon: the image waits for them."""

_lives: "WeakKeyDictionary[Session, Live]" = WeakKeyDictionary()


def live_of(session: Session) -> Live | None:
    """Return what listens to the bus of a session; None: its data do not come from a bus."""
    data, known = session.state.data, _lives.get(session)
    run_dir = Path(data.path)
    if data.kind != "live":
        return None
    if known is None or known.run_dir != run_dir:
        if known is not None:
            known.close()
        _lives[session] = known = Live(run_dir)
    return known


def build(session: Session) -> None:
    """Build the menu."""
    panel = ui.context.slot.parent
    place = ui.column().classes("w-full gap-2")

    def show() -> None:
        place.clear()
        with place:
            live = live_of(session)
            if live is None:
                ui.label(NONE).mark("live-none")
            else:
                _LivePage(session, live, panel)

    follow(session, place, lambda before, after: show() if before.data != after.data else None)
    show()


class _LivePage:
    """The page's widgets, and what keeps them up to date."""

    def __init__(self, session: Session, live: Live, shown_in: Element) -> None:
        self._session, self._live = session, live
        self._board = FrameBoard()
        self._shown_ping: tuple[int, bool] | None = None
        self._logged_ns = 0
        self.is_shown = True
        """Whether the menu is open; where it is not, nothing is made of what comes."""
        self._build()
        shown_in.client.on_delete(live.listen(self._came))
        shown_in.bind_visibility_to(self, "is_shown")
        follow(session, self._banner, self._changed)
        self._refresh()

    def _build(self) -> None:
        self._rates = ui.label().classes("text-sm opacity-80").mark("live-rates")
        self._banner = ui.label().classes("w-full rounded px-3 py-2 text-lg font-medium").mark("live-verdict")
        self._caution = ui.label().classes("text-warning").mark("live-caution")
        self._silence = ui.label().classes("text-negative font-medium").mark("live-silence")
        with ui.row().classes("w-full no-wrap gap-2"):
            with ui.element("div").classes("grow min-w-0").style("flex-basis: 38%"):
                self._fan = FanView(self._session, self._board, "live", title="Sonar", height=HEIGHT)
            with ui.element("div").classes("grow min-w-0").style("flex-basis: 34%"):
                self._plan = PlanView(title="Plan", height=HEIGHT, follows=True)
            with ui.element("div").classes("grow min-w-0").style("flex-basis: 28%"):
                self._times = ChartView(title="Latency", height=HEIGHT)
        self._plan.on_pick(self._picked)
        with ui.row().classes("w-full no-wrap gap-2 items-start max-xl:flex-wrap"):
            self._numbers = table("Obstacles", NUMBERS, self._mark).style("min-width: min(38rem, 60%)")
            self._tables = LiveTables(self._live)
        self._tables.build_others(self._session)
        ui.label("Log").classes("text-sm font-medium")
        self._log = ui.log(max_lines=SHOWN_LINES).classes("w-full").style("height: 150px").mark("live-log")

    def _picked(self, pick: Pick) -> None:
        if pick.id is not None:
            self._mark(pick.id)

    def _mark(self, identity: str) -> None:
        self._session.do(SetView("marked_obstacle", int(identity)))

    def _changed(self, before: State, after: State) -> None:
        if before.view != after.view:
            self._shown_ping = None
            self._draw_plan()

    # -- in the bus's thread --

    def _came(self, topic: str) -> None:
        if not self.is_shown:
            return
        if topic in ("ping", "detections"):
            self._show_image()
        elif topic == "":
            in_loop(self._banner, self._refresh)

    def _show_image(self) -> None:
        """Show the newest ping with its detections; without them only where the pipeline is silent."""
        live, now_ns = self._live, clock.monotonic_ns()
        ping, found = live.ping, live.detections
        if ping is None:
            return
        belongs = found is not None and found.ping_number == ping.ping_number and found.t_ns == ping.t_ns
        age_s = live.age_s("detections", now_ns)
        if not belongs and age_s is not None and age_s < DETECTS_S:
            return
        if (ping.seq, belongs) != self._shown_ping:
            self._shown_ping = ping.seq, belongs
            self._board.show("live", frame_of_ping(ping, found if belongs else None, self._session.state.view))

    # -- in the server's loop --

    def _refresh(self) -> None:
        live, now_ns = self._live, clock.monotonic_ns()
        self._draw_verdict(live.verdict(now_ns))
        rates = (f"{WORDS[topic]} {live.rate_hz(topic, now_ns):.1f}" for topic in ("ping", "pose", "obstacles"))
        self._rates.set_text(f"bus {live.run_dir}, read only. A second: {', '.join(rates)}")
        self._silence.set_text("; ".join(live.silences(now_ns)))
        self._fan.set_busy(next((text for text in live.silences(now_ns) if text.startswith("no pings")), ""))
        self._tables.show(now_ns)
        latest = live.obstacles
        self._numbers.rows = [] if latest is None else [numbers(item) for item in latest.obstacles]
        self._draw_plan()
        self._draw_latency(now_ns)
        self._draw_log()

    def _draw_verdict(self, verdict: Verdict) -> None:
        latest = self._live.obstacles
        if verdict.valid and latest is not None:
            count = len(latest.obstacles)
            text = f"VALID: a planner may rely on the list of ping {latest.ping_number}, {count} obstacles"
        else:
            text = "NOT VALID: " + "; ".join(verdict.reasons)
        colour = "bg-positive" if verdict.valid else "bg-negative"
        self._banner.set_text(text)
        self._banner.classes(replace=f"w-full rounded px-3 py-2 text-lg font-medium text-white {colour}")
        self._caution.set_text(verdict.caution)
        self._caution.set_visibility(bool(verdict.caution))

    def _draw_plan(self) -> None:
        live = self._live
        pose, latest = live.pose, live.obstacles
        shapes: list[Shape] = []
        if len(live.path) > 1:
            shapes.append(Way(list(live.path), "vehicle"))
        true = () if live.truth is None else live.truth.objects
        shapes += [Circle(observer_plan.flat(item.position_ned), item.radius_m, "truth") for item in true]
        marked = self._session.state.view.marked_obstacle
        if latest is not None:
            shapes += veto_shapes(latest)
            shapes += observer_plan.objects(latest, marked)
        if pose is not None:
            velocity = np.array(rotated(pose.attitude, pose.velocity_body))
            if latest is not None:
                shapes += observer_plan.approach(latest, marked, np.array(pose.position_ned), velocity)
            shapes.append(Mark(observer_plan.flat(pose.position_ned), "vehicle", heading_of(pose.attitude)))
        self._plan.show("now", shapes)

    def _draw_latency(self, now_ns: int) -> None:
        latency = self._live.latency(now_ns)
        at = latency.at_s
        curves = [
            Curve("first", "from transmission", at, latency.whole_ms),
            Curve("second", "from the last byte", at, latency.own_ms),
        ]
        if len(at):
            own_ms = latency.own_ms
            self._times.set_title(f"Latency: median {np.median(own_ms):.0f} ms, most {own_ms.max():.0f} ms")
        time, delay = Axis("time, s", -90.0, 0.0), Axis("list after ping, ms", span=20.0)
        self._times.show(time, [Panel(delay, curves)])

    def _draw_log(self) -> None:
        """Write what is new."""
        lines = list(self._live.log)
        for line in lines[-SHOWN_LINES:]:
            if line.utc_ns > self._logged_ns:
                self._log.push(said(line), classes="text-negative" if line.bad else "")
        self._logged_ns = max((line.utc_ns for line in lines), default=0)


def said(line: Line) -> str:
    """Return a line of the log with its time."""
    at = datetime.fromtimestamp(line.utc_ns / NS, UTC)
    return f"{at:%H:%M:%S} {line.text}"
