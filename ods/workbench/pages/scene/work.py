"""Long computations of the simulator's menu: the cost of an image's parts, and the rehearsal of a mission."""

import threading
from collections.abc import Callable

from nicegui import run, ui

from ods.workbench.engine.background.own_process import in_own_process, whole
from ods.workbench.engine.scene.cost import Cost, cost_of
from ods.workbench.engine.scene.rehearsal import Rehearsal, rehearse_file
from ods.workbench.engine.scene.view import SceneError
from ods.workbench.pages.parts.cost_bar import cost_bar
from ods.workbench.session import Session
from ods.workbench.web.follow import in_loop

PROGRESS_STEP = 0.02
"""Share of a mission between two words about how far it is."""


def build_cost(session: Session) -> None:
    """Build the cost bar, and the button that measures."""

    async def measure() -> None:
        button.props("loading")
        try:
            if (cost := await run.io_bound(_cost, session)) is not None:  # None: the server ends
                show(cost)
        finally:
            button.props(remove="loading")

    def show(cost: Cost) -> None:
        parts_us = [(name, 1e3 * ms) for name, ms in cost.parts_ms.items() if name != "total"]
        bar.set_content(cost_bar(parts_us, sum(us for _, us in parts_us)))
        paper = ", ".join(f"{name} {taken_s} s" for name, taken_s in cost.paper_s.items())
        total = cost.parts_ms["total"]
        line.set_text(
            f"One image: {total:.1f} ms of CPU, {total / cost.period_s / 10.0:.1f} % of the ping's period. "
            f"Table 1 of the paper, 1996: {paper}."
        )

    with ui.row().classes("items-center w-full"):
        ui.label("CPU time of an image's parts").classes("text-sm")
        button = ui.button("measure", icon="timer", on_click=measure).props("flat dense no-caps").mark("measure cost")
    bar = ui.html("", sanitize=False).classes("w-full text-sm")
    line = ui.label().classes("text-xs opacity-70").mark("cost")


def _cost(session: Session) -> Cost:
    state = session.state
    if state.scene is None:
        raise SceneError("scene: none is open")
    return in_own_process(cost_of, whole, state.scene, state.data.sonar)


def build_rehearsal(session: Session, shown: Callable[[Rehearsal | None], None]) -> None:
    """Build the button that rehearses, its progress and the scores. shown: gets what came of it."""
    _Rehearsal(session, shown)


class _Rehearsal:
    def __init__(self, session: Session, shown: Callable[[Rehearsal | None], None]) -> None:
        self._session, self._shown = session, shown
        self._ends = threading.Event()
        with ui.row().classes("items-center w-full gap-2"):
            self._button = ui.button("Rehearse", icon="play_arrow", on_click=self._run).props("dense no-caps")
            self._button.mark("rehearse").tooltip("simulate, detect, track and score the whole mission")
            self._stop = ui.button("stop", on_click=self._ends.set).props("flat dense no-caps").mark("stop")
            self._stop.set_visibility(False)
        self._bar = ui.linear_progress(value=0.0, show_value=False).props("instant-feedback")
        self._bar.set_visibility(False)
        self._summary = ui.label("Simulates, detects, tracks and scores the whole mission with configuration A.")
        self._summary.classes("text-xs opacity-70").mark("rehearsed")
        self._table = ui.table(columns=COLUMNS, rows=[], row_key="object").props("dense flat").classes("w-full")
        self._table.set_visibility(False)
        ui.label("With the real processes: save the scene, then ods bench --scene FILE.").classes("text-xs opacity-70")
        self._bar.client.on_delete(self._ends.set)

    async def _run(self) -> None:
        self._ends.clear()
        self._running(True)
        try:
            result = await run.io_bound(self._work)
        finally:
            self._running(False)
        if result is not None:
            self._show(result)
        self._shown(result)

    def _work(self) -> Rehearsal | None:
        state, last = self._session.state, 0.0
        if state.scene is None:
            raise SceneError("scene: none is open")

        def progress(share: float) -> bool:
            nonlocal last
            if share - last >= PROGRESS_STEP or share == 1.0:
                last = share
                in_loop(self._bar, lambda: self._bar.set_value(share))
            return not self._ends.is_set()

        return in_own_process(rehearse_file, progress, state.scene, state.data.sonar, state.tuning.mission())

    def _running(self, on: bool) -> None:
        self._button.set_enabled(not on)
        for each in (self._stop, self._bar):
            each.set_visibility(on)
        self._bar.set_value(0.0)

    def _show(self, result: Rehearsal) -> None:
        self._summary.set_text(
            f"{len(result.record.lists)} pings in {result.took_s:.1f} s: {result.detections} detections, "
            f"{result.false_tracks} false tracks, position rms {result.position_rms_m:.2f} m. "
            f"A ping's chain {result.chain_ms:.1f} ms, tracker {result.tracker_ms:.2f} ms."
        )
        self._table.rows = [
            {
                "object": item.name, "tracked": f"{item.tracked_share:.0%}", "rms": f"{item.position_rms_m:.2f}",
                "radius": f"{item.radius_error:+.0%}", "ids": " ".join(map(str, item.ids)),
            }
            for item in result.objects
        ]  # fmt: skip
        self._table.set_visibility(True)


COLUMNS = [
    {"name": name, "label": label, "field": name, "align": "left"}
    for name, label in (
        ("object", "object"), ("tracked", "tracked"), ("rms", "rms, m"), ("radius", "radius"), ("ids", "track ids"),
    )
]  # fmt: skip
