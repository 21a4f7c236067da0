"""Menu 6, Assess: the chain at hand on speed against accuracy among others, and what one setting does to both."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from nicegui import ui

from ods.pipeline.settings import PipelineSettings
from ods.workbench.engine import assessment
from ods.workbench.engine.assessment import Measured, Numeric, Point, SweepPoint, even_values, numbers_of
from ods.workbench.engine.background.newest import Newest
from ods.workbench.engine.background.own_process import OwnProcess
from ods.workbench.model.state import State
from ods.workbench.session import Session
from ods.workbench.web.follow import follow, in_loop
from ods.workbench.web.views.chart_view import Axis, ChartView, Colour, Curve, Panel, Style

OWN: tuple[Colour, ...] = ("first", "second")
"""Of A and B."""
_others: list[Point] = []
"""Measured once; the same for all browsers."""


class Chains(NamedTuple):
    """What is to be measured."""

    a: PipelineSettings
    b: PipelineSettings | None


class Sweep(NamedTuple):
    """What is to be swept."""

    state: State
    number: Numeric
    values: list[float]


def build(session: Session) -> None:
    """Build the menu."""
    with ui.row().classes("w-full no-wrap items-start gap-3 max-xl:flex-wrap"):
        with ui.card().classes("w-full min-w-0").props("flat bordered"):
            ui.label("Speed against accuracy").classes("text-base font-medium")
            _ChainsCard(session)
        with ui.card().classes("w-full min-w-0").props("flat bordered"):
            ui.label("Sweep of one setting").classes("text-base font-medium")
            _SweepCard(session)


class _Background:
    """A label and a bar that show the progress of work in the background."""

    def __init__(self) -> None:
        self.label = ui.label().classes("text-sm")
        self.bar = ui.linear_progress(0.0, show_value=False).classes("w-full")
        self.bar.set_visibility(False)

    def share(self, share: float, what: str) -> None:
        """Show how much is done; from any thread."""
        in_loop(self.bar, lambda: self._show(share, what))

    def ended(self, text: str = "") -> None:
        """Show that nothing is done any more; from any thread."""
        in_loop(self.bar, lambda: self._show(-1.0, text))

    def _show(self, share: float, text: str) -> None:
        self.bar.set_visibility(share >= 0.0)
        self.bar.set_value(max(share, 0.0))
        self.label.set_text(text)


class _ChainsCard:
    """The chart of chains."""

    def __init__(self, session: Session) -> None:
        self._work = _Background()
        self._own: list[Point] = []
        self._chart = ChartView(height="24rem").mark("chains")
        self._note = ui.label().classes("text-sm").mark("own chain")
        ui.label(
            f"{assessment.IMAGES} simulated images of ods assess detect; share of the objects found at "
            f"{assessment.FALSE_ALARMS:g} false alarm an image, the threshold swept; bars: 95 %"
        ).classes("text-xs opacity-70")
        self._process = OwnProcess(assessment.measured)
        self._newest = Newest(self._measure, self._tell, self._fail, self._process.end)
        self._chart.client.on_delete(self._newest.close)
        follow(session, self._chart, self._ask)
        self._ask(None, session.state)

    def _ask(self, before: State | None, after: State) -> None:
        wanted = _chains(after)
        if before is None or wanted != _chains(before):
            self._work.share(0.0, "measuring ...")
            self._newest.ask(wanted)

    def _measure(self, chains: Chains) -> Measured | None:
        named = {"A: this chain": chains.a} | ({} if chains.b is None else {"B": chains.b})
        return self._process(self._goes_on, named, () if _others else assessment.OTHERS, assessment.IMAGES)

    def _goes_on(self, share: float) -> bool:
        self._work.share(share, "measuring the chains of ODS" if share < 1.0 else "measuring this chain")
        return not self._newest.overtaken or not _others

    def _tell(self, _: Chains, measured: Measured | None) -> None:
        self._work.ended()
        if measured is not None:
            _others[:] = measured.others or _others
            in_loop(self._chart, lambda: self._show(measured.points))

    def _fail(self, _: Chains, error: Exception) -> None:
        self._work.ended(str(error))

    def _show(self, points: list[Point]) -> None:
        _show_chains(self._chart, points, _others)
        self._note.set_text("; ".join(
            f"{each.name}: {each.ms:.2f} ms an image; at its own levels {each.found_as_set:.0%} found, "
            f"{each.false_as_set:.2f} false alarms an image" for each in points
        ))  # fmt: skip


def _chains(state: State) -> Chains:
    return Chains(state.tuning.pipeline(), state.other.pipeline() if state.other else None)


def _show_chains(view: ChartView, own: Sequence[Point], others: Sequence[Point]) -> None:
    """Show a point a chain, with its interval."""
    coloured = list(zip(own, OWN, strict=False))
    curves = [line for point in others for line in _interval(point, "quiet")]
    curves += [line for point, role in coloured for line in _interval(point, role)]
    if others:
        curves.append(_points("others", others, "quiet", "points"))
    curves += [_points(point.name, [point], role, "diamonds") for point, role in coloured]
    view.show(Axis("ms an image", log=True), [Panel(Axis("objects found", 0.0, 1.0), curves)])


def _points(label: str, points: Sequence[Point], role: Colour, style: Style) -> Curve:
    ms, found = np.array([[each.ms, each.found] for each in points]).T
    return Curve(role, label, ms, found, style, [each.name for each in points])


def _interval(point: Point, role: Colour) -> list[Curve]:
    low, high = point.interval
    return [Curve(role, "", np.full(2, point.ms), np.array([low, high]))] if low == low else []


class _SweepCard:
    """What is swept, from where to where, and the curves."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._numbers: dict[str, Numeric] = {}
        with ui.row().classes("w-full items-end no-wrap"):
            self._chosen = ui.select({}, label="setting", with_input=True).classes("grow").mark("swept setting")
            self._low, self._high = ui.number("from").classes("w-16"), ui.number("to").classes("w-16")
            self._count = ui.number("values", value=9, min=2, max=40, precision=0).classes("w-14")
            self._factors = ui.switch("by factors").classes("whitespace-nowrap").tooltip("logarithmic scale")
            ui.button("Sweep", on_click=self._ask).props("dense no-caps").mark("sweep")
        self._work = _Background()
        self._chart = ChartView(height="26rem").mark("sweep chart")
        self._chart.set_visibility(False)
        self._process = OwnProcess(assessment.swept)
        self._newest = Newest(self._sweep, self._tell, self._fail, self._process.end)
        self._chart.client.on_delete(self._newest.close)
        self._chosen.on_value_change(lambda event: self._propose(event.value))
        follow(session, self._chart, self._list)
        self._list()

    def _list(self, *_: State) -> None:
        self._numbers = {each.path: each for each in numbers_of(self._session.state.tuning)}
        self._chosen.set_options({path: f"{each.label} = {each.value:g}" for path, each in self._numbers.items()})

    def _propose(self, path: str | None) -> None:
        """Propose from a third to three times of what it is."""
        if path in self._numbers:
            value = self._numbers[path].value
            low, high = (value / 3.0, 3.0 * value) if value else (0.0, 1.0)
            self._low.set_value(round(low) if self._numbers[path].whole else float(f"{low:.3g}"))
            self._high.set_value(round(high) if self._numbers[path].whole else float(f"{high:.3g}"))

    def _ask(self) -> None:
        number, low, high = self._numbers.get(self._chosen.value or ""), self._low.value, self._high.value
        if number is None or low is None or high is None or high <= low or (self._factors.value and low <= 0.0):
            ui.notify(
                "choose a setting and an increasing range; with a logarithmic scale it must start above 0",
                type="warning",
            )
            return
        count = min(40, max(2, int(self._count.value or 2)))
        values = even_values(low, high, count, by_factors=self._factors.value, whole=number.whole)
        self._work.share(0.0, f"{number.label}: measuring ...")
        self._newest.ask(Sweep(self._session.state, number, values))

    def _sweep(self, sweep: Sweep) -> list[SweepPoint] | None:
        def report(share: float) -> bool:
            self._work.share(share, sweep.number.label)
            return not self._newest.overtaken

        return self._process(report, sweep.state, sweep.number.path, sweep.values, assessment.IMAGES)

    def _tell(self, sweep: Sweep, points: list[SweepPoint] | None) -> None:
        if points is None:
            self._work.ended()
            return
        refused = len(sweep.values) - len(points)
        note = f", and {refused} that the setting refuses" if refused else ""
        self._work.ended(f"{sweep.number.label}: {len(points)} values{note}")
        in_loop(self._chart, lambda: self._show(sweep, points))

    def _fail(self, _: Sweep, error: Exception) -> None:
        self._work.ended(str(error))

    def _show(self, sweep: Sweep, points: Sequence[SweepPoint]) -> None:
        self._chart.set_visibility(True)
        _show_sweep(self._chart, sweep.number.label, points)


def _show_sweep(view: ChartView, label: str, points: Sequence[SweepPoint]) -> None:
    """Show what is found, false alarms and time over the setting's values."""
    values = np.array([each.value for each in points])
    found, false, ms = np.array([[each.found, each.false_alarms, each.ms] for each in points]).reshape(-1, 3).T
    panels = [
        Panel(Axis("objects found", 0.0, 1.0), [Curve("first", "", values, found, "dotted")], title="objects found"),
        Panel(Axis("an image", 0.0), [
            Curve("second", "false alarms", values, false, "dotted"), Curve("quiet", "ms", values, ms, "dotted"),
        ], title="false alarms and ms an image"),
    ]  # fmt: skip
    view.show(Axis(label), panels)
