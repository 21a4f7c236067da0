"""Menu 9, Missions: a mission with the planner in the loop; of a campaign's results the worst, one click each."""

import threading
from pathlib import Path

from nicegui import run, ui

from ods.base.files.shipped import FOLDER
from ods.missions.outcome import Outcome
from ods.workbench.engine.background.own_process import in_own_process
from ods.workbench.engine.files.folders import readable
from ods.workbench.engine.missions import Choice, Voyage, choices_of, fly
from ods.workbench.session import Session
from ods.workbench.web.follow import in_loop
from ods.workbench.web.views import plan_view as shapes
from ods.workbench.web.views.plan_view import PlanView, Shape

PROGRESS_STEP = 0.02


def build(session: Session) -> None:
    """Build the menu."""
    _Missions(session)


class _Missions:
    def __init__(self, session: Session) -> None:
        self._session = session
        self._ends = threading.Event()
        self._flying = False
        with ui.row().classes("w-full no-wrap items-start"):
            with ui.column().classes("w-96 shrink-0 gap-1"):
                self._build_opening()
                self._list = ui.list().props("dense bordered").classes("w-full max-h-96 overflow-auto")
            with ui.column().classes("grow min-w-0"):
                with ui.row().classes("items-center w-full"):
                    self._line = ui.label(
                        "Choose a mission: it is run with the configuration and world of its campaign."
                    )
                    self._line.classes("text-sm").mark("mission result")
                    self._stop = ui.button("stop", on_click=self._ends.set).props("flat dense no-caps")
                    self._stop.set_visibility(False)
                self._bar = ui.linear_progress(value=0.0, show_value=False).props("instant-feedback")
                self._bar.set_visibility(False)
                self._plan = PlanView(title="path, obstacles and the last list", height="calc(100vh - 9.5rem)")
        self._bar.client.on_delete(self._ends.set)

    def _build_opening(self) -> None:
        shipped = {str(each): each.stem for each in sorted((FOLDER / "campaigns").glob("*.toml"))}
        chosen = ui.select(shipped, label="campaigns of ODS", with_input=True).classes("w-full")
        chosen.on_value_change(lambda event: self._open(event.value))
        path = ui.input("folder of ods missions --out, or a campaign's file").classes("w-full").mark("campaign path")
        path.on("keydown.enter", lambda: self._open(path.value))

    def _open(self, path: str | None) -> None:
        if not path:
            return
        choices = choices_of(readable(Path(path).expanduser(), self._session.folders))
        self._list.clear()
        with self._list:
            for choice in choices:
                ui.item(text_of(choice), on_click=lambda choice=choice: self._fly(choice)).mark("mission")

    async def _fly(self, choice: Choice) -> None:
        if self._flying:
            return
        self._ends.clear()
        self._running(True)
        try:
            voyage = await run.io_bound(self._work, choice)
        finally:
            self._running(False)
        if voyage is not None:
            self._plan.show("voyage", shapes_of(voyage))
            self._plan.fit()
            self._line.set_text(f"{choice.name}, mission {choice.number}: {said_of(voyage.outcome)}")

    def _work(self, choice: Choice) -> Voyage | None:
        last = 0.0

        def report(share: float) -> bool:
            nonlocal last
            if share - last >= PROGRESS_STEP:
                last = share
                in_loop(self._bar, lambda: self._bar.set_value(share))
            return not self._ends.is_set()

        return in_own_process(fly, report, choice)

    def _running(self, on: bool) -> None:
        self._flying = on
        for each in (self._stop, self._bar):
            each.set_visibility(on)
        self._bar.set_value(0.0)


def text_of(choice: Choice) -> str:
    """Return a mission as a line of the list."""
    came = "not run yet" if choice.outcome is None else said_of(choice.outcome)
    return f"{choice.name}, mission {choice.number}: {came}"


def said_of(outcome: Outcome) -> str:
    """Return what came of a mission, and what was listed of the obstacle that it came nearest to."""
    if outcome.clearance_m is None:
        return f"{outcome.ending}, no obstacles"
    nearest = "listed" if outcome.nearest_listed else f"not listed, {outcome.warning or 'no warning'}"
    return f"{outcome.ending}, least clearance {outcome.clearance_m:.1f} m (that obstacle {nearest})"


def shapes_of(voyage: Voyage) -> list[Shape]:
    """Return a mission as shapes of the plan."""
    drawn: list[Shape] = [shapes.Line([a, b], "path", dashed=True) for a, b in voyage.paths]
    drawn += [shapes.Circle(place, radius, "object") for place, radius in voyage.obstacles]
    drawn += [shapes.Circle(place, radius, "active", dashed=True) for place, radius in voyage.listed]
    drawn += [shapes.Line(voyage.way, "vehicle"), shapes.Mark(voyage.goal, "goal", label="goal")]
    return drawn
