"""One picture: accuracy of the methods against time."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from benchmarks.level_methods.measure import Figures
from ods.assess.detection.metrics import CONFIDENCE
from ods.base.arrays import Floats
from ods.plots.chart import dress, label_points, number, save_figure
from ods.plots.style import ACCENT, GOOD, MARK, WARN, drawn_in

DEFAULT = "extreme values 0.3"
MISSED = 0.5, 2.0
"""False echoes an image that were asked for."""


def save_chart(path: Path, figures: Sequence[Figures], bed: str, style: str) -> None:
    """Draw the methods; bed: whose bodies. Raises OdsError when the picture cannot be written."""
    with drawn_in(style):
        figure = Figure(figsize=(13.0, 6.6), dpi=100)
        figure.subplots_adjust(left=0.06, right=0.985, top=0.86, bottom=0.1, wspace=0.16)
        left, right = figure.subplots(1, 2, sharex=True)
        _draw(figure, left, figures, np.array([one.found[bed] for one in figures]))
        dress(left, "bodies over sea-beds, at 1 false echo an image", _TIME, "share found")
        left.set_ylim(bottom=0.0)
        right.axhspan(*MISSED, color=GOOD, alpha=0.15, lw=0.0)
        right.set_yscale("log")
        number(right.yaxis)
        _draw(figure, right, figures, np.array([_spread(one) for one in figures]))
        dress(right, "clutter without echoes, level set for 1 on speckle", _TIME, "false echoes an image")
        figure.suptitle(
            f"star: the default; open: plain numpy, whose time says little of the method. Left: bars {CONFIDENCE:.0%},"
            " bootstrap over the images;\nright: median and range over K of shape 0.5 to 5 in cells and patches;"
            " band: what was asked for", fontsize=10,
        )  # fmt: skip
        save_figure(figure, path)


_TIME = "processor ms an image of 60 x 2000, everything included"


def _spread(one: Figures) -> tuple[float, float, float]:
    """Return median, least and most false echoes on K-distributed clutter; the least is drawn at 0.05 at least."""
    values = [value for name, value in one.clutter.items() if name.startswith("K")]
    return float(np.median(values)), max(min(values), 0.05), max(values)


def _draw(figure: Figure, axes: Axes, figures: Sequence[Figures], values: Floats) -> None:
    """Draw values (methods, 3): middle, and ends of the bar."""
    axes.set_xscale("log")
    number(axes.xaxis)
    axes.xaxis.set_major_locator(LogLocator(10.0, (1.0, 2.0, 5.0)))
    labels = []
    for one, (middle, low, high) in zip(figures, values, strict=True):
        is_default = one.method.name == DEFAULT
        colour = MARK if is_default else WARN if one.method.plain else ACCENT
        axes.plot((one.ms, one.ms), (low, high), color=colour, lw=1.0, marker="_", ms=5, alpha=0.6)
        axes.plot(one.ms, middle, "*" if is_default else "o", color=colour, ms=15 if is_default else 6,
                  mfc="none" if one.method.plain else colour)  # fmt: skip
        labels.append((one.method.name, one.ms, float(middle), colour))
    low, high = axes.get_xlim()
    axes.set_xlim(low / 1.6, high * 1.6)  # room for names
    bars = zip(figures, values, strict=True)
    ends = np.vstack([np.column_stack([np.full(5, one.ms), np.linspace(low, high, 5)]) for one, (_, low, high) in bars])
    label_points(figure, axes, labels, ends)
