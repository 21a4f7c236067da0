"""Common parts of charts: axes, plain numbers on logarithmic ones, labels that do not overlap, the file."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ods.base.arrays import Floats
from ods.base.errors import OdsError, reason_of
from ods.plots.style import outline

LABEL_SIZE = 8.5
"""Of labels beside points, points."""
_WIDTH, _HEIGHT = 0.72, 1.3
"""Of a letter, in sizes of the letters."""
_DIRECTIONS, _DISTANCES = 16, (8.0, 13.0, 19.0, 26.0, 34.0, 44.0, 56.0, 70.0)
"""Where a label is tried, around its point, points."""
_LEADER = 15.0
"""From this distance on a line leads from the label to its point."""


def save_figure(figure: Figure, path: Path) -> None:
    """Write a picture. Raises OdsError."""
    try:
        figure.savefig(path)
    except (OSError, ValueError) as error:
        raise OdsError(f"{path}: {reason_of(error)}") from error


def style_axes(axes: Axes, title: str, x: str, y: str) -> None:
    """Give axes their texts and a grid, and a legend if anything is labelled."""
    axes.set_title(title)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(visible=True)
    if axes.get_legend_handles_labels()[0]:
        axes.legend()


def number(*logarithmic: Axis) -> None:
    """Give logarithmic axes plain numbers."""
    for axis in logarithmic:
        axis.set_major_locator(LogLocator(10.0, (1.0, 1.5, 2.0, 3.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def label_points(
    figure: Figure, axes: Axes, labels: Sequence[tuple[str, float, float, str]], taken: Floats | None = None
) -> None:
    """Write texts beside points: (text, x, y, colour), so that none covers another or a point. Draw all else before.

    taken: (n, 2) further points, x and y, that no text should cover.
    """
    if not labels:
        return
    figure.draw_without_rendering()  # places the axes
    to_points = 72.0 / figure.dpi
    points = axes.transData.transform([(x, y) for _, x, y, _ in labels]) * to_points
    others = points if taken is None else np.vstack([points, axes.transData.transform(taken) * to_points])
    sizes = np.array([(_WIDTH * LABEL_SIZE * len(text), _HEIGHT * LABEL_SIZE) for text, *_ in labels])
    corners = axes.bbox.get_points() * to_points
    for (text, x, y, colour), offset in zip(labels, spread(points, sizes, others, corners), strict=True):
        far = float(np.hypot(*offset)) > _LEADER
        axes.annotate(
            text, (x, y), xytext=tuple(offset), textcoords="offset points", color=colour, fontsize=LABEL_SIZE,
            ha="center", va="center", path_effects=outline(),
            arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.6} if far else None,
        )  # fmt: skip


def spread(points: Floats, sizes: Floats, taken: Floats, corners: Floats) -> Floats:
    """Return (n, 2) offsets of the labels' middles from points (n, 2): one by one the nearest place that is free.

    sizes: (n, 2) of the labels; taken: (m, 2) places that they should not cover, the points among them; corners: (2, 2)
    lower left and upper right of where they may lie; all in one unit. Where nothing is free: what covers least.
    """
    angles = np.arange(_DIRECTIONS) * (2.0 * np.pi / _DIRECTIONS) + 0.25 * np.pi
    around = np.column_stack([np.cos(angles), np.sin(angles)])
    steps = (np.array(_DISTANCES)[:, None, None] * around).reshape(-1, 2)
    placed = np.empty((0, 4))
    offsets = np.empty((len(points), 2))
    for i, (point, size) in enumerate(zip(points, sizes, strict=True)):
        candidates = steps + np.sign(steps) * 0.5 * size * np.abs(steps) / np.hypot(*steps.T)[:, None]
        middle = point + candidates
        boxes = np.hstack([middle - 0.5 * size, middle + 0.5 * size])
        outside = np.any((boxes[:, :2] < corners[0]) | (boxes[:, 2:] > corners[1]), axis=1)
        labels = _overlaps(boxes, placed)
        covered = _overlaps(boxes, np.hstack([taken, taken]))
        best = int(np.argmin(100.0 * labels + 100.0 * outside + covered))  # the first of the best: the nearest
        offsets[i] = candidates[best]
        placed = np.vstack([placed, boxes[best]])
    return offsets


def _overlaps(boxes: Floats, others: Floats) -> Floats:
    """Return (n,) how many of the others, (m, 4), each box, (n, 4) left, bottom, right and top, overlaps."""
    apart = np.any((boxes[:, None, :2] >= others[:, 2:]) | (boxes[:, None, 2:] <= others[:, :2]), axis=2)
    return np.asarray((~apart).sum(axis=1), np.float64)
