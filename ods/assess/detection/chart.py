"""One picture of accuracy against time: simulated sea and tank look-alikes, Pareto fronts marked and named."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ods.assess.detection.chains import DEFAULT
from ods.assess.detection.measure import SettingRow
from ods.assess.detection.metrics import pareto_front
from ods.base.errors import OdsError
from ods.plots.fan import INK, MARK, PAPER

FRONT = "#ffa657"
OTHER = "#8b949e"


def save_chart(path: Path, rows: Sequence[SettingRow], front: Sequence[int]) -> None:
    """Draw all settings. Raises OdsError when the picture cannot be written."""
    figure = Figure(figsize=(13.0, 8.5), dpi=100, facecolor=PAPER)
    left, right = figure.subplots(1, 2, sharex=True)
    figure.subplots_adjust(left=0.06, right=0.98, top=0.95, bottom=0.36, wspace=0.14)  # names stand below
    ms = [row.ms for row in rows]
    tank = [row.tank.detection_probability for row in rows]
    _draw(
        left,
        rows,
        [row.sea.detection_probability for row in rows],
        front,
        "simulated sea, 60 x 2000, at 1 false alarm an image",
    )
    _draw(right, rows, tank, pareto_front(ms, tank), "tank look-alikes, 128 x 500, at 4")
    try:
        figure.savefig(path)
    except (OSError, ValueError) as error:
        raise OdsError(f"{path}: {error}") from error


def _draw(axes: Axes, rows: Sequence[SettingRow], accuracy: Sequence[float], front: Sequence[int], title: str) -> None:
    named = [index for index, row in enumerate(rows) if index in front or row.name == DEFAULT]
    for index, (row, share) in enumerate(zip(rows, accuracy, strict=True)):
        chosen = row.name == DEFAULT
        colour = MARK if chosen else FRONT if index in front else OTHER
        axes.plot(row.ms, share, "*" if chosen else "o", color=colour, ms=13 if chosen else 6 if index in front else 3)
        if index in named:
            up = 4 if named.index(index) % 2 else -10
            axes.annotate(
                str(index), (row.ms, share), xytext=(6, up), textcoords="offset points", color=colour, fontsize=8
            )
    axes.plot([rows[i].ms for i in front], [accuracy[i] for i in front], color=FRONT, lw=1.0, drawstyle="steps-post")
    for place, index in enumerate(named):
        axes.annotate(
            f"{index}  {rows[index].name}",
            (0.0, -0.16 - 0.038 * place),
            xycoords="axes fraction",
            color=MARK if rows[index].name == DEFAULT else FRONT,
            fontsize=9,
        )
    _dress(axes, title)


def _dress(axes: Axes, title: str) -> None:
    axes.set_facecolor(PAPER)
    axes.set_xscale("log")
    axes.set_title(title, color=INK)
    axes.set_xlabel("ms an image of 60 x 2000, everything included, one core", color=INK)
    axes.set_ylabel("detection probability", color=INK)
    axes.tick_params(colors=INK, which="both")
    axes.grid(color=INK, alpha=0.15)
    for spine in axes.spines.values():
        spine.set_visible(False)
