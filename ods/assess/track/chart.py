"""One picture of accuracy against time of all trackers, and of each scenario's ratio to the reference."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ods.assess.track.measure import Row
from ods.base.errors import OdsError
from ods.plots.fan import INK, MARK, PAPER

COLOURS = (MARK, "#ffa657", "#7ee787", "#d2a8ff", "#ff7b72", "#8b949e", "#f2cc60", "#ffffff")


def save_figure(figure: Figure, path: Path) -> None:
    """Write a picture. Raises OdsError."""
    try:
        figure.savefig(path)
    except (OSError, ValueError) as error:
        raise OdsError(f"{path}: {error}") from error


def chart(rows: Sequence[Row]) -> Figure:
    """Return the chart: left all scenarios of a tracker with their middle, right scenario by scenario."""
    figure = Figure(figsize=(13.0, 7.0), dpi=110, facecolor=PAPER, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
    trackers = list(dict.fromkeys(row.tracker for row in rows))
    names = list(dict.fromkeys(row.scenario for row in rows))
    for index, tracker in enumerate(trackers):
        mine, colour = [row for row in rows if row.tracker == tracker], COLOURS[index % len(COLOURS)]
        ms, ratio = [row.ms for row in mine], [row.ratio for row in mine]
        left.plot(ms, ratio, "o", color=colour, ms=4, alpha=0.6)
        middle = np.exp(np.mean(np.log(ms))), np.exp(np.mean(np.log(ratio)))
        left.plot(*middle, "*", color=colour, ms=16, label=f"{tracker} ({len(mine)} scenarios)")
        places = [names.index(row.scenario) for row in mine]
        right.plot(ratio, places, "o", color=colour, ms=7, label=tracker)
    limits = {row.scenario: row.limits.gospa for row in rows}
    right.plot([limits[name] for name in names], range(len(names)), "|", color=INK, ms=13, mew=1.5, label="limit")
    right.set_yticks(range(len(names)), names)
    right.invert_yaxis()
    dress(left, "all scenarios, star: geometric mean", "CPU time of a scan, ms, median", "GOSPA over the reference's")
    dress(right, "GOSPA in view over the reference's", "1: identities and motion class known", "")
    left.set_xscale("log")
    left.set_yscale("log")
    right.set_xscale("log")
    number(left.xaxis, left.yaxis, right.xaxis)
    return figure


def number(*logarithmic: Axis) -> None:
    """Give logarithmic axes plain numbers."""
    for axis in logarithmic:
        axis.set_major_locator(LogLocator(10.0, (1.0, 1.5, 2.0, 3.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def dress(axes: Axes, title: str, x: str, y: str) -> None:
    """Give axes the colours of all our charts, and a legend if anything is labelled."""
    axes.set_facecolor(PAPER)
    axes.set_title(title, color=INK)
    axes.set_xlabel(x, color=INK)
    axes.set_ylabel(y, color=INK)
    axes.tick_params(colors=INK, which="both")
    axes.grid(color=INK, alpha=0.15)
    for spine in axes.spines.values():
        spine.set_visible(False)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(facecolor=PAPER, edgecolor="none", labelcolor=INK, fontsize=9)
