"""`ods simulate --chart`: error against time of every model level."""

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ods.base.errors import OdsError
from ods.plots.fan import INK, PAPER
from ods.sim_sonar.sonar.model import SonarModel
from ods.simulate.speed import Curve, curve_of

SCENES = {
    "empty": "empty fan",
    "flat_bottom": "flat bottom",
    "figure11": "figure 11",
    "rough_50": "rough sea-bed, 50 objects",
}
ENDINGS = (".png", ".svg", ".pdf")
CURVE_COLOURS = ("#8b949e", "#39d0ff", "#ffa657", "#ff7b72")
EXACT, EXACT_DB = 1e-3, 1e-2
"""Where errors below these are drawn: a level that is exact has no place on a logarithmic axis."""


def draw_chart(sonar: SonarModel, path: Path) -> None:
    """Measure all model levels on four scenes and draw them. Raises OdsError."""
    if path.suffix not in ENDINGS:
        raise OdsError(f"{path}: the ending must be one of {', '.join(ENDINGS)}")
    if not path.parent.is_dir():
        raise OdsError(f"{path}: no such folder: {path.parent}")
    curves = [curve_of(sonar, name) for name in SCENES]
    figure = curve_figure(curves, f"Mean image of {sonar.name}, {sonar.beams} x {sonar.samples}: error against time")
    try:
        figure.savefig(path)
    except OSError as error:
        raise OdsError(f"{path}: {error.strerror}") from error


def curve_figure(curves: list[Curve], title: str) -> Figure:
    """Return the chart: relative errors left, in dB right; a ring marks what the automatic choice picks."""
    figure = Figure(figsize=(13.0, 5.5), dpi=110, facecolor=PAPER, layout="constrained")
    figure.suptitle(title, color=INK)
    left, right = figure.subplots(1, 2)
    for curve, colour in zip(curves, CURVE_COLOURS, strict=True):
        points, picked = curve.points, curve.picked
        times = [point.ms for point in points]
        name = SCENES.get(curve.scene, curve.scene)
        left.plot(times, [max(point.error, EXACT) for point in points], "o-", color=colour, ms=4, label=name)
        right.plot(times, [max(point.error_db, EXACT_DB) for point in points], "o-", color=colour, ms=4, label=name)
        ring = {"mfc": "none", "mec": colour, "ms": 13, "mew": 1.8}
        left.plot(picked.ms, max(picked.error, EXACT), "o", **ring)
        right.plot(picked.ms, max(picked.error_db, EXACT_DB), "o", **ring)
    left.axhline(curves[-1].picked.max_error, color=INK, lw=0.8, ls=":")
    left.annotate("max_error", (0.99, curves[-1].picked.max_error), xycoords=("axes fraction", "data"), color=INK,
                  ha="right", va="bottom", fontsize=8)  # fmt: skip
    _dress(left, "rms error over rms of the reference")
    _dress(right, "rms error, dB")
    left.legend(
        loc="lower right",
        facecolor=PAPER,
        labelcolor=INK,
        edgecolor=INK,
        title="ring: automatic choice",
        title_fontsize=9,
    )
    left.get_legend().get_title().set_color(INK)
    return figure


def _dress(axes: Axes, label: str) -> None:
    axes.set(
        xscale="log", yscale="log", xlabel="CPU time of a whole image, ms", ylabel=f"{label} (lowest: that or less)"
    )
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda ms, _: f"{ms:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_facecolor(PAPER)
    axes.grid(color=INK, alpha=0.15, which="both")
    axes.tick_params(colors=INK, which="both")
    axes.xaxis.label.set_color(INK)
    axes.yaxis.label.set_color(INK)
    for spine in axes.spines.values():
        spine.set_color(INK)
