"""Curves of the image processing menu: range profile, histogram, cost."""

import itertools
from collections.abc import Callable
from html import escape

import numpy as np
from nicegui import ui

from ods.workbench.engine.ping.look import HIGHEST_DB, LOWEST_DB, Look, histogram, profile
from ods.workbench.engine.ping.study import Cost, Study
from ods.workbench.engine.ping.thresholds import thresholds
from ods.workbench.model.state import Tuning
from ods.workbench.pages.ping.pictures import pooled_db, title_of
from ods.workbench.pages.ping.work import Answer, Costs, last_stage
from ods.workbench.web.curve_view import Axis, CurveView, EvenCurve, Line
from ods.workbench.web.time_view import Colour

MOST_CURVES, MOST_POINTS = 4, 500
ROLES: tuple[Colour, ...] = ("first", "second", "third", "truth")
COLOURS = ("#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#0072b2", "#d55e00", "#999999", "#f0e442")
"""Okabe and Ito's, of the parts of the cost."""


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
        self._view = CurveView(height="13rem").classes("w-full").mark("profile")
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
        study, tuning = _chains(self._answer)[who]
        return study.after(int(place), tuning.bypassed)

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
            if beam >= len(look.codes):
                continue
            values, step = pooled_db(profile(look, beam), MOST_POINTS)
            first = grid.range0_m + 0.5 * (step - 1) * grid.dr_m
            curves.append(EvenCurve(role, options[name], first, step * grid.dr_m, values))
        highest = max((value for curve in curves for value in curve.values if value is not None), default=40.0)
        last = self._answer.a.looks[-1]
        levels = thresholds(last, last_stage(self._answer.state.tuning)[1])
        self._view.show(
            f"beam {beam}, bearing {np.degrees(grid.bearing_rad[beam]):.1f}°",
            (Axis("slant range, m", grid.range0_m, grid.range0_m + grid.samples * grid.dr_m),
             Axis("dB over the image's median", -25.0, max(45.0, highest + 18.0))),
            curves, [Line(each.name, "y", each.level_db, "approach", each.draggable) for each in levels],
        )  # fmt: skip


def _chains(answer: Answer) -> dict[str, tuple[Study, Tuning]]:
    """Return A and the chains that are kept, by their names; without those that cannot be."""
    state = answer.state
    studies, tunings = (answer.a, answer.b, *answer.further), (state.tuning, state.other, *state.further)
    named = zip("ABCD", studies, tunings, strict=False)
    return {name: (study, tuning) for name, study, tuning in named if study is not None and tuning is not None}


class Histogram:
    """How many cells of the last image have what level."""

    def __init__(self, dragged: Callable[[str, float], None]) -> None:
        self._view = CurveView(height="16rem").classes("w-full").mark("histogram")
        self._view.on_drag(dragged)

    def answer(self, answer: Answer) -> None:
        """Show the newest answer."""
        last = answer.a.looks[-1]
        curves = [_bars(last, "first", "A" if answer.b else "")]
        if answer.b is not None:
            curves.append(_bars(answer.b.looks[-1], "second", "B"))
        levels = thresholds(last, last_stage(answer.state.tuning)[1])
        self._view.show(
            f"what {last.label} compares",
            (Axis("dB over the image's median", LOWEST_DB, HIGHEST_DB), Axis("cells", -0.3, 5.0, log=True)),
            curves, [Line(each.name, "x", each.level_db, "approach", each.draggable) for each in levels],
        )  # fmt: skip


def _bars(look: Look, role: Colour, label: str) -> EvenCurve:
    counted = histogram(look)
    logs: list[float | None] = [round(float(np.log10(cells)), 3) if cells else None for cells in counted.cells.tolist()]
    width = float(counted.edges_db[1] - counted.edges_db[0])
    return EvenCurve(role, label, float(counted.edges_db[0]), width, logs, filled=label != "B")


class CostBars:
    """What each stage takes of the time until the next ping, of A and of B: one element, as it changes often."""

    def __init__(self) -> None:
        ui.label("Cost of one ping").classes("text-sm font-medium")
        self._shown = ui.html("", sanitize=False).classes("w-full text-sm").mark("cost")

    def show(self, costs: Costs, period_s: float | None) -> None:
        """Show the newest answer."""
        most = max(cost.whole for _, cost in costs)
        rows = (f"<div>{who} {_summary(cost, period_s)}</div>{_bar(cost, most)}" for who, cost in costs)
        self._shown.set_content("".join(rows))


def _summary(cost: Cost, period_s: float | None) -> str:
    text = f"{cost.whole / 1e3:.2f} ms"
    if period_s:
        text += f": {cost.whole / 1e4 / period_s:.2g} % of the {1e3 * period_s:.0f} ms between pings"
    return f"{text}; {cost.prepared / 1e3:.0f} ms once to prepare"


def _bar(cost: Cost, most: float) -> str:
    """Return the bar of one chain and its legend, as HTML."""
    parts = [(escape(name), time_us) for name, time_us in (*cost.stages, ("read, measure", cost.rest))]
    coloured = list(zip(parts, itertools.cycle(COLOURS), strict=False))
    bars = (
        f'<div class="h-full" style="width: {100.0 * time_us / most:.2f}%; background: {colour}" '
        f'title="{name}: {time_us:.0f} µs"></div>'
        for (name, time_us), colour in coloured
    )
    legend = (
        f'<span class="text-xs whitespace-nowrap"><span class="inline-block w-2 h-2 mr-1" style="background: {colour}">'
        f"</span>{name} {time_us:.0f} µs</span>"
        for (name, time_us), colour in coloured
    )
    bar, names = "".join(bars), "".join(legend)
    return f'<div class="flex no-wrap h-4">{bar}</div><div class="flex flex-wrap gap-x-3">{names}</div>'
