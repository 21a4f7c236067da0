"""`ods simulate --chart`: error against time of every model level."""

from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ods.plots.chart import save_figure, style_axes
from ods.plots.style import ACCENT, BAD, MARK, QUIET, STRONG, drawn_in
from ods.sim_sonar.sonar.model import SonarModel
from ods.simulate.speed import Curve, curve_of

SCENES = {
    "empty": "empty fan",
    "flat_bottom": "flat bottom",
    "figure11": "figure 11",
    "rough_50": "rough sea-bed, 50 objects",
}
CURVE_COLOURS = (QUIET, MARK, ACCENT, BAD)
EXACT = 1e-3
"""Where errors below this are drawn: a level that is exact has no place on a logarithmic axis."""


def draw_chart(sonar: SonarModel, path: Path, style: str) -> None:
    """Measure all model levels on four scenes and draw them. Raises OdsError."""
    curves = [curve_of(sonar, name) for name in SCENES]
    with drawn_in(style):
        save_figure(curve_figure(curves, f"Mean image of {sonar.name}, {sonar.beams} x {sonar.samples}"), path)


def curve_figure(curves: list[Curve], title: str) -> Figure:
    """Return the chart; a ring marks what the automatic choice picks."""
    figure = Figure(figsize=(8.0, 5.5), dpi=110, layout="constrained")
    axes = figure.subplots()
    for curve, colour in zip(curves, CURVE_COLOURS, strict=True):
        points, picked = curve.points, curve.picked
        errors = [max(point.error, EXACT) for point in points]
        name = SCENES.get(curve.scene, curve.scene)
        axes.plot([point.ms for point in points], errors, "o-", color=colour, ms=4, label=name)
        axes.plot(picked.ms, max(picked.error, EXACT), "o", mfc="none", mec=colour, ms=13, mew=1.8)
    axes.axhline(curves[-1].picked.max_error, color=STRONG, lw=0.8, ls=":")
    axes.annotate("max_error", (0.99, curves[-1].picked.max_error), xycoords=("axes fraction", "data"), ha="right",
                  va="bottom", fontsize=9)  # fmt: skip
    axes.annotate(
        "this or less", (0.99, EXACT), xycoords=("axes fraction", "data"), ha="right", va="center", fontsize=9
    )
    axes.set(xscale="log", yscale="log")
    style_axes(axes, title, "CPU time of a whole image, ms", "rms error over rms of the reference")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda ms, _: f"{ms:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.legend(
        loc="upper left", bbox_to_anchor=(0.0, -0.12), ncols=4, title="ring: automatic choice", columnspacing=1.2
    )
    return figure
