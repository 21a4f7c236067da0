"""The chart: collisions per 100 missions against time a ping, one panel a speed."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ods.missions.chart.point import Point
from ods.plots.chart import label_points, style_axes
from ods.plots.style import SERIES

WIDTH, HEIGHT = 4.6, 5.0
"""Of a panel, inches."""


def chart_figure(points: Sequence[Point]) -> Figure:
    """Return the chart; bars are Wilson's 95 % intervals, points by images are hollow."""
    speeds = list(dict.fromkeys(each.speed_m_s for each in points))
    kinds = list(dict.fromkeys(each.varies for each in points))
    figure = Figure(figsize=(WIDTH * len(speeds) + 0.6, HEIGHT), dpi=110, layout="constrained")
    panels = figure.subplots(1, len(speeds), sharey=True, sharex=True, squeeze=False)[0]
    for axes, speed in zip(panels, speeds, strict=True):
        own = [each for each in points if each.speed_m_s == speed]
        for kind in kinds:
            _draw([each for each in own if each.varies == kind], axes, SERIES[kinds.index(kind) % len(SERIES)])
        of = [f"{point.collision.of} missions by {point.fidelity}" for point in own]
        style_axes(axes, "\n".join([f"vehicle at {speed:g} m/s", *dict.fromkeys(of)]),
              "CPU time a ping, pipeline and tracker, ms", "collisions per 100 missions")  # fmt: skip
    for axes in panels[1:]:
        axes.set_ylabel("")
    panels[0].set_ylim(bottom=0.0)
    panels[0].set_xlim(left=0.0)
    for axes, speed in zip(panels, speeds, strict=True):
        label_points(figure, axes, [
            (each.name, each.ms, 100.0 * each.collision.share, SERIES[kinds.index(each.varies) % len(SERIES)])
            for each in points if each.speed_m_s == speed and each.fidelity == "detections"
        ])  # fmt: skip
    return figure


def _draw(points: Sequence[Point], axes: Axes, colour: str) -> None:
    for each in points:
        rate = each.collision
        middle = 100.0 * rate.share
        down, up = max(0.0, middle - 100.0 * rate.low), max(0.0, 100.0 * rate.high - middle)
        face = "none" if each.fidelity == "images" else colour
        axes.errorbar(each.ms, middle, yerr=[[down], [up]], fmt="o", color=colour, mfc=face, ms=5, lw=1.2, capsize=3)
