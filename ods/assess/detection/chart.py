"""One picture of accuracy against time: simulated sea and tank look-alikes, Pareto fronts marked and named."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ods.assess.detection.chains import DEFAULT
from ods.assess.detection.measure import Accuracy, SettingRow
from ods.assess.detection.metrics import CONFIDENCE, pareto_front
from ods.base.arrays import Floats
from ods.plots.chart import label_points, number, save_figure, style_axes
from ods.plots.style import ACCENT, MARK, QUIET, drawn_in

ABOVE, AXES, BELOW, LINE = 0.8, 5.6, 0.9, 0.19
"""Inches: above the axes, of the axes, below them up to the names, from name to name."""


@dataclass(frozen=True)
class Panel:
    """What one half of the chart shows."""

    rows: Sequence[SettingRow]
    accuracy: Sequence[Accuracy]

    @cached_property
    def ms(self) -> Floats:
        """Return the time of each setting."""
        return np.array([row.ms for row in self.rows])

    @cached_property
    def share(self) -> Floats:
        """Return the detection probability of each."""
        return np.array([one.detection_probability for one in self.accuracy])

    @cached_property
    def front(self) -> list[int]:
        """Return the settings on the Pareto front."""
        return pareto_front(self.ms.tolist(), self.share.tolist())

    @cached_property
    def default(self) -> int:
        """Return which is the default chain, which is always measured."""
        return next(index for index, row in enumerate(self.rows) if row.name == DEFAULT)

    @cached_property
    def named(self) -> list[int]:
        """Return those that are labelled with number and name."""
        return sorted({*self.front, self.default})

    def colour(self, index: int) -> str:
        """Return the colour of a setting with a name."""
        return MARK if index == self.default else ACCENT

    def names(self) -> list[tuple[str, str]]:
        """Return the lines below the axes, and their colours: where the default stands, and what the numbers mean."""
        labels = [(text, MARK) for text in self.where_default_stands()]
        return labels + [(f"{index}  {self.rows[index].name}", self.colour(index)) for index in self.named]

    def where_default_stands(self) -> list[str]:
        """Return whether the default is on the front, and what the best setting finds for what time."""
        ms, share, default = self.ms, self.share, self.default
        lines = [f"{default} finds {share[default]:.3f} in {ms[default]:.2f} ms"]
        faster = [index for index in self.front if ms[index] < ms[default] and share[index] >= share[default]]
        if faster:
            first = faster[0]
            lines[0] += f", off the front: {first} finds {share[first]:.3f} in {ms[first]:.2f} ms"
        else:
            lines[0] += ", on the front: no faster setting finds as much"
        best = self.front[-1]
        if share[best] > share[default]:
            inside = self.accuracy[default].interval[1] >= share[best]
            lines.append(
                f"the best setting, {best}, finds {share[best]:.3f} in {ms[best] / ms[default]:.2f} times the time,"
                f" {'inside' if inside else 'above'} the default's error bar"
            )
        return lines


def save_chart(path: Path, rows: Sequence[SettingRow], style: str) -> None:
    """Draw all settings. Raises OdsError when the picture cannot be written."""
    with drawn_in(style):
        save_figure(chart(rows), path)


def chart(rows: Sequence[SettingRow]) -> Figure:
    """Return the chart: both fronts, with error bars there and at the default, which is explained."""
    sea, tank = Panel(rows, [row.sea for row in rows]), Panel(rows, [row.tank for row in rows])
    below = BELOW + LINE * max(len(panel.names()) for panel in (sea, tank))
    height = ABOVE + AXES + below
    figure = Figure(figsize=(13.0, height), dpi=100)
    figure.subplots_adjust(left=0.06, right=0.98, top=1.0 - ABOVE / height, bottom=below / height, wspace=0.14)
    left, right = figure.subplots(1, 2, sharex=True)
    _draw(figure, left, sea, "simulated sea, 60 x 2000, at 1 false alarm an image")
    _draw(figure, right, tank, "tank look-alikes, 128 x 500, at 4 unlabelled clusters an image")
    figure.suptitle(
        f"line: Pareto front; star: the default chain; bars: {CONFIDENCE:.0%}, bootstrap over the images", fontsize=10
    )
    return figure


def _draw(figure: Figure, axes: Axes, panel: Panel, title: str) -> None:
    ms, share, front = panel.ms, panel.share, panel.front
    axes.set_xscale("log")
    number(axes.xaxis)
    style_axes(axes, title, "ms an image of 60 x 2000, everything included, one core", "detection probability")
    axes.plot(ms, share, "o", color=QUIET, ms=2.5, alpha=0.7)
    axes.plot(ms[front], share[front], color=ACCENT, lw=1.0, drawstyle="steps-post")
    for index in panel.named:
        is_default = index == panel.default
        colour = panel.colour(index)
        axes.plot((ms[index], ms[index]), panel.accuracy[index].interval, color=colour, lw=1.0, marker="_", ms=5,
                  alpha=1.0 if is_default else 0.5)  # fmt: skip
        axes.plot(ms[index], share[index], "*" if is_default else "o", color=colour, ms=15 if is_default else 6)
    labels = [(str(index), ms[index], share[index], panel.colour(index)) for index in panel.named]
    label_points(figure, axes, labels, np.column_stack([ms, share]))
    for place, (text, colour) in enumerate(panel.names()):
        axes.annotate(text, (0.0, -(BELOW - 0.1 + LINE * place) / AXES), xycoords="axes fraction", color=colour,
                      fontsize=9)  # fmt: skip
