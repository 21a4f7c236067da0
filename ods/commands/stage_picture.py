"""The picture of `ods detect --plot-stages`: all images of a ping on one colour scale, and the detector's levels.

Images are drawn range against bearing, not as fans, so that all share one range axis with the curves below them.
"""

from collections.abc import Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from ods.base.arrays import Floats, Floats32, Image
from ods.messages import Detection, Detections
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.watch import StageImage
from ods.plots.fan import style_colour_bar
from ods.plots.style import BAD, GOOD, MARK, QUIET, STRONG, outline

COLUMNS = 1000
"""Range samples that are drawn at most; of those that share one the highest is shown."""
LOWEST_DB, HIGHEST_DB = -10.0, 40.0
"""Ends of the colour scale at most, over the median of each image."""
FAINTEST = 1e-3
"""Amplitudes below this part of the median are drawn as this."""
SAME_PLANE_RAD = 1e-6
LOW, HIGH, STRONGEST, MIDDLE = GOOD, BAD, STRONG, QUIET


class Drawn(NamedTuple):
    """An image as it is drawn."""

    label: str
    level_db: Floats32
    """(beams, samples) over its own median."""
    fan: Fan
    levels_db: tuple[float, float] | None
    """Low and high level of the detector that judged it."""


def stages_figure(title: str, stages: Sequence[StageImage], found: Detections) -> Figure:
    """Return one picture of a ping: a column of images for each plane or ring of ranges, with curves below.

    stages: as `Chain` showed them, in order.
    """
    columns = [_column(list(group)) for _, group in groupby(stages, key=lambda stage: id(stage.fan))]
    rows = max(map(len, columns))
    figure = Figure(figsize=(2.0 + 10.0 * len(columns), 1.2 + 1.75 * rows + 3.0), dpi=110,
                    layout="constrained")  # fmt: skip
    figure.suptitle(title, fontsize=13)
    axes = figure.subplots(rows + 1, len(columns), sharex="col", squeeze=False, height_ratios=[*[1.0] * rows, 1.7])
    limits = _limits([drawn for column in columns for drawn in column])
    for column, below in zip(columns, axes.T, strict=True):
        for drawn, panel in zip(column, below[:-1], strict=False):
            picture = _draw_image(panel, drawn, limits)
        for panel in below[len(column) : -1]:
            panel.set_axis_off()
        for panel in (below[0], below[len(column) - 1]):
            _draw_detections(panel, found.detections, column[0].fan)
        _draw_curves(below[-1], column[-1])
    bar = figure.colorbar(picture, ax=axes[:-1].ravel().tolist(), pad=0.01, aspect=40)
    style_colour_bar(bar, "dB over the image's median")
    return figure


def _column(stages: list[StageImage]) -> list[Drawn]:
    """Return what is drawn of one plane or ring; the image that the detector judged is drawn once."""
    *before, last = stages
    if before and np.array_equal(before[-1].image, last.image):
        stages = [*before[:-1], last._replace(label=f"{before[-1].label}, detected by {last.label}")]
    elif last.levels:
        stages = [*before, last._replace(label=f"{last.label}: levels compared with the thresholds")]
    return [_drawn(stage) for stage in stages]


def _drawn(stage: StageImage) -> Drawn:
    positive = stage.image[stage.image > 0.0]
    unit = float(np.median(positive)) if positive.size else 1.0
    levels = stage.levels and (_db(stage.levels[0] / unit), _db(stage.levels[1] / unit))
    return Drawn(stage.label, _level_db(stage.image, unit), stage.fan, levels)


def _level_db(image: Image, unit: float) -> Floats32:
    return np.asarray(20.0 * np.log10(np.maximum(image / unit, FAINTEST)), np.float32)


def _db(ratio: float) -> float:
    return float(20.0 * np.log10(max(ratio, FAINTEST)))


def _limits(drawn: Sequence[Drawn]) -> tuple[float, float]:
    """Return the ends of the one colour scale: what all images span but for their faintest and brightest cells."""
    low = min(float(np.quantile(each.level_db, 0.02)) for each in drawn)
    high = max(float(np.quantile(each.level_db, 0.9995)) for each in drawn)
    return max(low, LOWEST_DB), min(max(high, 10.0), HIGHEST_DB)


def _draw_image(axes: Axes, drawn: Drawn, limits: tuple[float, float]) -> Any:
    fan = drawn.fan
    _dress(axes, "bearing, deg")
    axes.set_title(drawn.label, fontsize=10, loc="left")
    for part in filter(len, np.split(np.arange(fan.samples), [fan.seam] if fan.seam else [])):
        pool = -(-len(part) // COLUMNS)
        shown = np.maximum.reduceat(drawn.level_db[:, part], np.arange(0, len(part), pool), axis=1)
        near = fan.range_m[part[0]] - 0.5 * fan.dr_m
        edges = np.append(near + fan.dr_m * np.arange(0, len(part), pool), fan.range_m[part[-1]] + 0.5 * fan.dr_m)
        picture = axes.pcolorfast(edges, np.degrees(fan.borders_rad), shown, vmin=limits[0],
                                  vmax=limits[1])  # fmt: skip
    axes.invert_yaxis()  # port above, as a look ahead turned to the right
    return picture


def _draw_detections(axes: Axes, detections: Sequence[Detection], fan: Fan) -> None:
    """Draw those of this plane and these ranges, numbered as all are."""
    near, far = fan.range_m[0], fan.range_m[-1]
    for number, each in enumerate(detections, 1):
        if not (near <= each.range_m <= far and abs(each.elevation_rad - fan.elevation_rad) < SAME_PLANE_RAD):
            continue
        bearing = np.degrees(each.bearing_rad)
        half = np.degrees(np.arcsin(min(1.0, each.radius_m / max(each.range_m, 1e-9))))
        axes.add_patch(Ellipse((each.range_m, bearing), 2.0 * each.radius_m, 2.0 * half, fill=False, ec=MARK, lw=1.2))
        axes.annotate(
            str(number), (each.range_m + each.radius_m, bearing - half), xytext=(1, 1), textcoords="offset points",
            color=MARK, fontsize=8, path_effects=outline(), annotation_clip=True,
        )  # fmt: skip


def _draw_curves(axes: Axes, drawn: Drawn) -> None:
    """Draw what the detector sees at each range, and its levels."""
    _dress(axes, "last image,\ndB over its median")
    range_m = drawn.fan.range_m.copy()
    for values, colour, label in (
        (drawn.level_db.max(axis=0), STRONGEST, "strongest beam"),
        (np.median(drawn.level_db, axis=0), MIDDLE, "median of the beams"),
    ):
        axes.plot(*_with_gap(range_m, values, drawn.fan.seam), color=colour, lw=0.8, label=label)
    if drawn.levels_db:
        low, high = drawn.levels_db
        names = ((high, HIGH, "high level"), (low, LOW, "low level"))
        for level, colour, name in names if low < high else names[:1]:
            axes.axhline(level, color=colour, lw=1.2, label=f"{name}, {level:.1f} dB")
    axes.set_ylim(LOWEST_DB, max(20.0, float(drawn.level_db.max()) + 3.0))
    axes.set_xlabel("slant range, m")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncol=4, fontsize=9, frameon=False)


def _with_gap(range_m: Floats, values: Floats32, seam: int | None) -> tuple[Floats, Floats32]:
    """Break a curve where ranges are left out."""
    if not seam:
        return range_m, values
    return np.insert(range_m, seam, np.nan), np.insert(values, seam, np.nan)


def _dress(axes: Axes, label: str) -> None:
    axes.set_ylabel(label, fontsize=9)
    axes.tick_params(labelsize=8)
