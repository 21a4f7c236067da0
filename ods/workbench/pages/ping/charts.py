"""Curves of the image processing menu: range profile, histogram, cost."""

from collections.abc import Callable

import numpy as np
from nicegui import ui

from ods.workbench.engine.ping.analysis import Cost, PingAnalysis
from ods.workbench.engine.ping.look import HIGHEST_DB, LOWEST_DB, Look, histogram, profile
from ods.workbench.engine.ping.thresholds import thresholds
from ods.workbench.model.state import Tuning
from ods.workbench.pages.parts.cost_bar import cost_bar
from ods.workbench.pages.ping.pictures import title_of
from ods.workbench.pages.ping.work import Answer, Costs, last_stage
from ods.workbench.web.views.chart_view import Axis, ChartView, Colour, Curve, Even, Line, Panel

MOST_CURVES = 4
ROLES: tuple[Colour, ...] = ("first", "second", "third", "fourth")
LEAST_HIGH_DB = 42.0
"""What a profile's axis reaches up to at least."""
MOST_CELLS = 1e5


class Profile:
    """The levels along one beam, after up to four stages."""

    def __init__(self, dragged: Callable[[str, float], None]) -> None:
        self._answer: Answer | None = None
        self._beam: int | None = None
        """None: the middle one."""
        self._chosen: list[str] | None = None
        """None: recorded and last of A, and last of B."""
        self._choice = ui.select({}, multiple=True, label="range profile of (up to 4)", on_change=self._choose)
        self._choice.props("dense options-dense borderless").classes("w-full").mark("profiles")
        self._view = ChartView(height="15rem").mark("profile")
        self._view.on_drag(dragged)

    def answer(self, answer: Answer) -> None:
        """Show the newest answer."""
        self._answer = answer
        options = self._options(answer)
        chosen = self._names(options)
        if self._choice.options != options or self._choice.value != chosen:
            self._choice.set_options(options, value=chosen)
        self._draw()

    def beam(self, beam: int) -> None:
        """Show another beam."""
        if beam != self._beam:
            self._beam = beam
            self._draw()

    def _options(self, answer: Answer) -> dict[str, str]:
        chains = _chains(answer)
        return {
            f"{who} {place}": (f"{who}: " if len(chains) > 1 else "") + title_of(tuning, place)
            for who, (_, tuning) in chains.items()
            for place in range(-1, len(tuning.config.pipeline.chain()))
        }

    def _names(self, options: dict[str, str]) -> list[str]:
        if self._chosen is not None and (kept := [name for name in self._chosen if name in options]):
            return kept
        assert self._answer is not None
        last = -2 if self._answer.further else -1  # of many chains after the filter, by which they are named
        ends = [[name for name in options if name.startswith(who)][last] for who in _chains(self._answer)]
        return ["A -1", *ends][-MOST_CURVES:]

    def _choose(self) -> None:
        if self._answer is None or self._choice.value == self._names(self._options(self._answer)):
            return
        self._chosen = list(self._choice.value)[:MOST_CURVES]
        if len(self._choice.value) > MOST_CURVES:
            ui.notify(f"{MOST_CURVES} curves at most")
            self._choice.set_value(self._chosen)
        self._draw()

    def _look(self, name: str) -> Look:
        assert self._answer is not None
        who, _, place = name.partition(" ")
        analysis, tuning = _chains(self._answer)[who]
        return analysis.after(int(place), tuning.bypassed)

    def _draw(self) -> None:
        if self._answer is None:
            return
        grid = self._answer.a.grid
        beams = len(grid.bearing_rad)
        beam = beams // 2 if self._beam is None else min(self._beam, beams - 1)
        options = self._options(self._answer)
        curves = []
        for role, name in zip(ROLES, self._names(options), strict=False):
            look = self._look(name)
            if beam < len(look.codes):
                curves.append(Curve(role, options[name], Even(grid.range0_m, grid.dr_m), profile(look, beam)))
        highest = max((float(np.nanmax(curve.y, initial=LEAST_HIGH_DB)) for curve in curves), default=LEAST_HIGH_DB)
        last = self._answer.a.looks[-1]
        levels = thresholds(last, last_stage(self._answer.state.tuning)[1])
        lines = [Line(each.name, "y", each.level_db, "approach", each.draggable) for each in levels]
        far_m = grid.range0_m + grid.samples * grid.dr_m
        self._view.set_title(f"beam {beam}, bearing {np.degrees(grid.bearing_rad[beam]):.1f}°")
        self._view.show(
            Axis("slant range, m", grid.range0_m, far_m, cursor="range"),
            [Panel(Axis("dB over median", -25.0, highest + 3.0, cursor="level"), curves, lines=lines)],
        )


def _chains(answer: Answer) -> dict[str, tuple[PingAnalysis, Tuning]]:
    """Return A and the chains that are kept, by their names; without those that cannot be."""
    state = answer.state
    studies, tunings = (answer.a, answer.b, *answer.further), (state.tuning, state.other, *state.further)
    named = zip("ABCD", studies, tunings, strict=False)
    return {name: (analysis, tuning) for name, analysis, tuning in named if analysis is not None and tuning is not None}


class Histogram:
    """How many cells of the last image have what level."""

    def __init__(self, dragged: Callable[[str, float], None]) -> None:
        self._view = ChartView(height="17rem").mark("histogram")
        self._view.on_drag(dragged)

    def answer(self, answer: Answer) -> None:
        """Show the newest answer."""
        last = answer.a.looks[-1]
        curves = [_bars(last, "first", "A" if answer.b else "")]
        if answer.b is not None:
            curves.append(_bars(answer.b.looks[-1], "second", "B"))
        levels = thresholds(last, last_stage(answer.state.tuning)[1])
        lines = [Line(each.name, "x", each.level_db, "approach", each.draggable) for each in levels]
        self._view.set_title(f"what {last.label} compares")
        self._view.show(
            Axis("dB over the image's median", LOWEST_DB, HIGHEST_DB, cursor="level"),
            [Panel(Axis("cells", 0.5, MOST_CELLS, log=True), curves, lines=lines)],
        )


def _bars(look: Look, role: Colour, label: str) -> Curve:
    counted = histogram(look)
    cells = np.where(counted.cells > 0, counted.cells, np.nan)
    width = float(counted.edges_db[1] - counted.edges_db[0])
    middle = Even(float(counted.edges_db[0]) + 0.5 * width, width)
    return Curve(role, label, middle, cells, "steps" if label == "B" else "bars")


class CostBars:
    """What each stage takes of the time until the next ping, of A and of B: one element, as it changes often."""

    def __init__(self) -> None:
        ui.label("Cost of one ping").classes("text-sm font-medium")
        self._shown = ui.html("", sanitize=False).classes("w-full text-sm").mark("cost")

    def show(self, costs: Costs, period_s: float | None) -> None:
        """Show the newest answer."""
        most = max(cost.whole for _, cost in costs)
        bars = ((*cost.stages, ("read, measure", cost.rest)) for _, cost in costs)
        rows = (
            f"<div>{who} {_summary(cost, period_s)}</div>{cost_bar(parts, most)}"
            for (who, cost), parts in zip(costs, bars, strict=True)
        )
        self._shown.set_content("".join(rows))


def _summary(cost: Cost, period_s: float | None) -> str:
    text = f"{cost.whole / 1e3:.2f} ms"
    if period_s:
        text += f": {cost.whole / 1e4 / period_s:.2g} % of the {1e3 * period_s:.0f} ms between pings"
    return f"{text}; {cost.prepared / 1e3:.0f} ms once to prepare"
