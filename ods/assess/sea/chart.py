"""One picture of false obstacles, tracked objects and the time to confirm them, scene by scene."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ods.assess.sea.judge import SceneScore
from ods.assess.sea.table import FALSE_LIMIT, TRACKED_LIMIT
from ods.plots.chart import style_axes
from ods.plots.style import ACCENT, MARK, STRONG


def chart(scores: Sequence[SceneScore]) -> Figure:
    """Return the chart."""
    figure = Figure(figsize=(13.0, 1.6 + 0.42 * len(scores)), dpi=110, layout="constrained")
    false, tracked, range_of = figure.subplots(1, 3, sharey=True, width_ratios=(1.2, 1.0, 1.0))
    rows = range(len(scores))
    false.barh(rows, [score.false_a_minute for score in scores], color=ACCENT, height=0.6)
    for row, score in enumerate(scores):
        for target in score.targets:
            tracked.plot(100.0 * target.share, row, "o", color=MARK, ms=6, alpha=0.7)
            range_of.plot(target.confirmed_m, row, "o", color=MARK, ms=6, alpha=0.7)
    _limit(false, FALSE_LIMIT)
    _limit(tracked, 100.0 * TRACKED_LIMIT)
    false.set_yticks(rows, [score.name for score in scores])
    false.invert_yaxis()
    false.margins(x=0.12, y=0.02)
    style_axes(false, "false obstacles", "per minute; dotted: upper limit", "")
    style_axes(tracked, "objects tracked", "% of the lists; dotted: lower limit", "")
    style_axes(range_of, "confirmed", "at a distance of, m", "")
    _label(false, [score.false_a_minute for score in scores])
    return figure


def _label(axes: Axes, values: Sequence[float]) -> None:
    """Write the values behind their bars, on a ground of their own: the line of the limit may run there."""
    for row, value in enumerate(values):
        axes.annotate(f"{value:.1f}", (value, row), xytext=(4, 0), va="center", textcoords="offset points", fontsize=9,
                      bbox={"facecolor": axes.get_facecolor(), "edgecolor": "none", "pad": 1.0})  # fmt: skip


def _limit(axes: Axes, value: float) -> None:
    axes.axvline(value, color=STRONG, lw=1.0, ls=":")
