"""One picture of accuracy against time of all trackers, and of each scenario's ratio to the reference."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator
from scipy.stats import bootstrap

from ods.assess.track.measure import Row
from ods.base.arrays import Floats
from ods.plots.chart import number, style_axes
from ods.plots.style import QUIET, SERIES, STRONG

MARKERS = "oDs^vP"
"""One for each association; a colour stands for an observer."""
RATIOS = 1.0, 1.2, 1.5, 2.0, 3.0, 5.0
"""Ticks of the ratios, times powers of ten: most limits are 1.2."""
BAND = 0.8
"""Share of a scenario's row that its trackers stand in, one under the other."""


def chart(rows: Sequence[Row]) -> Figure:
    """Return the chart: left all scenarios of a tracker with their middle, right scenario by scenario."""
    names = list(dict.fromkeys(row.scenario for row in rows))
    trackers = list(dict.fromkeys(row.tracker for row in rows))
    figure = Figure(figsize=(13.0, 3.0 + 0.42 * len(names)), dpi=110, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.35))
    looks = _looks(trackers)
    for place, tracker in enumerate(trackers):
        mine = [row for row in rows if row.tracker == tracker]
        _draw_means(left, mine, *looks[tracker])
        down = BAND * ((place + 0.5) / len(trackers) - 0.5)
        _draw_ratios(right, mine, [names.index(row.scenario) + down for row in mine], *looks[tracker])
    _draw_limits(right, rows, names)
    right.set_yticks(range(len(names)), names)
    right.set_ylim(len(names) - 0.5, -0.5)
    for axes in (left, right):
        axes.set_xscale("log")
    left.set_yscale("log")
    number(left.xaxis, left.yaxis, right.xaxis)
    for axis in (left.yaxis, right.xaxis):
        axis.set_major_locator(LogLocator(10.0, RATIOS))
        axis.set_minor_locator(NullLocator())
    style_axes(
        left, "all scenarios; large: geometric mean", "CPU time of a scan, ms, median", "GOSPA over the reference's"
    )
    style_axes(
        right,
        "scenario by scenario, GOSPA over the reference's",
        "1: the reference, which knows identities and motion",
        "",
    )
    right.grid(visible=False, axis="y")
    for axes in (left, right):
        axes.get_legend().remove()
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    return figure


def _looks(trackers: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Return colour and marker of each tracker: those of its observer, and of its association."""
    parts = {name: name.partition(", ")[::2] for name in trackers}
    observers, ways = (list(dict.fromkeys(part)) for part in zip(*parts.values(), strict=True))
    return {
        name: (SERIES[observers.index(observer) % len(SERIES)], MARKERS[ways.index(way) % len(MARKERS)])
        for name, (observer, way) in parts.items()
    }


def _draw_means(axes: Axes, mine: Sequence[Row], colour: str, marker: str) -> None:
    """Draw a tracker's scenarios, and their geometric mean with the interval that draws of scenarios give it."""
    ms, ratio = np.array([(row.ms, row.ratio) for row in mine]).T
    axes.plot(ms, ratio, marker, color=colour, ms=3.5, alpha=0.5)
    middle = _geometric_mean(ms), _geometric_mean(ratio)
    if len(mine) > 1:
        found = bootstrap((ratio,), _geometric_mean, vectorized=False, method="percentile", n_resamples=500,
                          rng=np.random.default_rng(0)).confidence_interval  # fmt: skip
        axes.plot((middle[0], middle[0]), (found.low, found.high), color=colour, lw=1.2)
    axes.plot(*middle, marker, color=colour, ms=10, mec=STRONG, mew=0.8, label=mine[0].tracker)


def _geometric_mean(values: Floats) -> float:
    return float(np.exp(np.mean(np.log(values))))


def _draw_ratios(axes: Axes, mine: Sequence[Row], places: Sequence[float], colour: str, marker: str) -> None:
    for row, place in zip(mine, places, strict=True):
        axes.plot(row.ratio_interval, (place, place), color=colour, lw=1.1)
    label = f"{mine[0].tracker} ({len(mine)} scenarios)"
    axes.plot([row.ratio for row in mine], places, marker, color=colour, ms=4.5, ls="none", label=label)


def _draw_limits(axes: Axes, rows: Sequence[Row], names: Sequence[str]) -> None:
    """Draw each scenario's limit over its row, and stripes that keep rows apart."""
    limits = {row.scenario: row.limits.gospa for row in rows}
    for place, name in enumerate(names):
        if place % 2:
            axes.axhspan(place - 0.5, place + 0.5, color=QUIET, alpha=0.1, lw=0.0)
        limit = limits[name]
        if limit is not None:
            axes.plot((limit, limit), (place - 0.42, place + 0.42), color=STRONG, lw=1.5,
                      label="" if place else "limit")  # fmt: skip
    axes.axvline(1.0, color=QUIET, lw=0.8, ls=":")
