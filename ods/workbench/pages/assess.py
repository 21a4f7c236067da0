"""Menu 6, Assess: the chain at hand on speed against accuracy among others, and what one setting does to both."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from nicegui import ui

from ods.pipeline.settings import PipelineSettings
from ods.workbench.engine import assessment
from ods.workbench.engine.assessment import Measured, Numeric, Point, SweepPoint, even_values, numbers_of
from ods.workbench.engine.background.newest import Newest
from ods.workbench.engine.background.own_process import OwnProcess
from ods.workbench.model.state import State
from ods.workbench.session import Session
from ods.workbench.web.follow import follow, in_loop

OWN, B, OTHER, FALSE = "#0969da", "#d4610c", "#8b949e", "#cf222e"
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
            ui.label("One setting from end to end").classes("text-base font-medium")
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
        self._chart = ui.echart(_chains_chart([], [])).classes("w-full h-96").mark("chains")
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
        self._chart.options.clear()
        self._chart.options.update(_chains_chart(points, _others))
        self._chart.update()
        self._note.set_text("; ".join(
            f"{each.name}: {each.ms:.2f} ms an image; at its own levels {each.found_as_set:.0%} found, "
            f"{each.false_as_set:.2f} false alarms an image" for each in points
        ))  # fmt: skip


def _chains(state: State) -> Chains:
    return Chains(state.tuning.pipeline(), state.other.pipeline() if state.other else None)


def _chains_chart(own: Sequence[Point], others: Sequence[Point]) -> dict[str, Any]:
    """Return the options of the chart: a point a chain, with its interval."""
    colours = (OWN, B)
    series = [_scatter("others", others, OTHER, "circle", 9)] if others else []
    for point, colour in zip(own, colours, strict=False):
        series.append(_scatter(point.name, [point], colour, "diamond", 18))
    series += [_interval(point, OTHER) for point in others]
    series += [_interval(point, colour) for point, colour in zip(own, colours, strict=False)]
    return {
        "animation": False,
        "textStyle": {"color": OTHER},
        "grid": {"left": 60, "right": "18%", "top": 40, "bottom": 50},
        "legend": {"data": [each["name"] for each in series if each["type"] == "scatter"],
                   "textStyle": {"color": OTHER}, "top": 0},
        "tooltip": {"trigger": "item"},
        "xAxis": {**_axis("ms an image", "log"), **_decades([each.ms for each in (*own, *others)]),
                  "axisLabel": {"showMaxLabel": False}},  # lines to the names run over it
        "yAxis": {**_axis("objects found", "value"), "min": 0, "max": 1},
        "series": series,
    }  # fmt: skip


def _decades(ms: Sequence[float]) -> dict[str, float]:
    """Return ends of the axis that leave room at both sides."""
    return {"min": round(0.6 * min(ms), 2), "max": round(2.0 * max(ms), 2)} if ms else {}


def _scatter(name: str, points: Sequence[Point], colour: str, symbol: str, size: int) -> dict[str, Any]:
    """Return points; their names stand in a column beside the chart, as chains are often as good as others."""
    return {
        "type": "scatter", "name": name, "symbol": symbol, "symbolSize": size, "itemStyle": {"color": colour}, "z": 3,
        "data": [{"name": each.name, "value": [round(each.ms, 3), round(each.found, 3)]} for each in points],
        "label": {"show": True, "formatter": "{b}", "position": "right", "color": colour, "fontSize": 10,
                  "minMargin": 8},
        "labelLayout": {"x": "84%", "moveOverlap": "shiftY"}, "labelLine": {"show": True, "length2": 5},
        "tooltip": {"formatter": "{b}<br>{c}"},
    }  # fmt: skip


def _interval(point: Point, colour: str) -> dict[str, Any]:
    low, high = point.interval
    return {
        "type": "line", "silent": True, "showSymbol": False, "lineStyle": {"color": colour, "width": 1},
        "data": [[round(point.ms, 3), low], [round(point.ms, 3), high]] if low == low else [],
    }  # fmt: skip


def _axis(name: str, kind: str) -> dict[str, Any]:
    return {"type": kind, "name": name, "nameLocation": "middle", "nameGap": 30 if kind == "log" else 40,
            "axisLine": {"show": True}, "splitLine": {"lineStyle": {"opacity": 0.2}}}  # fmt: skip


class _SweepCard:
    """What is swept, from where to where, and the curves."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._numbers: dict[str, Numeric] = {}
        with ui.row().classes("w-full items-end no-wrap"):
            self._chosen = ui.select({}, label="setting", with_input=True).classes("grow").mark("swept setting")
            self._low, self._high = ui.number("from").classes("w-16"), ui.number("to").classes("w-16")
            self._count = ui.number("values", value=9, min=2, max=40, precision=0).classes("w-14")
            self._factors = ui.switch("by factors").classes("whitespace-nowrap").tooltip("even steps of the logarithm")
            ui.button("Sweep", on_click=self._ask).props("dense no-caps").mark("sweep")
        self._work = _Background()
        self._chart = ui.echart(_sweep_chart("", [])).classes("w-full h-96").mark("sweep chart")
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
            ui.notify("choose a setting, and from where to where, upwards; by factors from above 0", type="warning")
            return
        count = min(40, max(2, int(self._count.value or 2)))
        values = even_values(low, high, count, by_factors=self._factors.value, whole=number.whole)
        self._work.share(0.0, f"{number.label}: measuring ...")
        self._newest.ask(Sweep(self._session.state, number, values))

    def _sweep(self, sweep: Sweep) -> list[SweepPoint] | None:
        def tell(share: float) -> bool:
            self._work.share(share, sweep.number.label)
            return not self._newest.overtaken

        return self._process(tell, sweep.state, sweep.number.path, sweep.values, assessment.IMAGES)

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
        self._chart.options.clear()
        self._chart.options.update(_sweep_chart(sweep.number.label, points))
        self._chart.update()


def _sweep_chart(label: str, points: Sequence[SweepPoint]) -> dict[str, Any]:
    """Return the options of the chart: found and false alarms over the setting's values."""
    curves = {
        "objects found": (0, OWN, [[each.value, round(each.found, 3)] for each in points]),
        "false alarms an image": (1, FALSE, [[each.value, round(each.false_alarms, 3)] for each in points]),
        "ms an image": (1, OTHER, [[each.value, round(each.ms, 3)] for each in points]),
    }
    return {
        "animation": False,
        "textStyle": {"color": OTHER},
        "grid": {"left": 60, "right": 60, "top": 40, "bottom": 50},
        "legend": {"data": list(curves), "textStyle": {"color": OTHER}, "top": 0},
        "tooltip": {"trigger": "axis"},
        "xAxis": {**_axis(label or "a setting of the chain", "value"), "scale": True, "nameGap": 30},
        "yAxis": [
            {**_axis("objects found", "value"), "min": 0, "max": 1},
            {**_axis("false alarms, ms, an image", "value"), "min": 0, "splitLine": {"show": False}},
        ],
        "series": [
            {"type": "line", "name": name, "yAxisIndex": axis, "itemStyle": {"color": colour}, "data": data}
            for name, (axis, colour, data) in curves.items()
        ],
    }
