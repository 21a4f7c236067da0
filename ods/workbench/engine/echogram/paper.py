"""An echogram on paper: its levels, the layers that are switched on, and the hash of the configuration."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from ods.base.arrays import Floats32
from ods.plots.fan import style_colour_bar
from ods.plots.style import ACCENT, BAD, GOOD, MARK, OTHER, WARN, drawn_in, outline
from ods.workbench.engine.echogram.layers import TRUTH, Layers, Span, Way
from ods.workbench.engine.echogram.levels import Echogram, title_of
from ods.workbench.engine.files.folders import write_whole
from ods.workbench.engine.files.prints import PICTURES, config_hash, place_to_write
from ods.workbench.model.state import State

COLUMNS, CELLS = 1000, 600
"""That a picture has at most: what shares one is its highest level."""
COLOURS = {"active": GOOD, "stand_by": WARN, "hibernated": MARK, TRUTH: ACCENT}


def print_echogram(
    echogram: Echogram, layers: Layers, state: State, file: Path, folders: Sequence[Path], *, name: str, style: str
) -> Path:
    """Draw it into a file, with the colours and layers of the state; the file's ending chooses the format. Raises
    OdsError."""
    place = place_to_write(file, PICTURES, folders)
    with drawn_in(style):
        figure = _figure(echogram, layers, state)
        caption = f"{name}: {echogram.pings} pings; configuration {config_hash(state.tuning)}"
        figure.text(0.01, 0.005, caption, fontsize=8, ha="left", va="bottom")
        drawn = BytesIO()
        figure.savefig(drawn, format=place.suffix[1:], metadata={"Title": caption})
    write_whole(place, drawn.getvalue())
    return place


def pooled(levels: Floats32, columns: int, cells: int) -> Floats32:
    """Return levels (columns, cells) with at most this number of cells, the highest of those that share one."""
    for axis, most in enumerate((columns, cells)):
        count = levels.shape[axis]
        if count > most:
            levels = np.fmax.reduceat(levels, np.arange(most) * count // most, axis=axis)
    return levels


def _figure(echogram: Echogram, layers: Layers, state: State) -> Figure:
    view = state.view
    layout = ConstrainedLayoutEngine(rect=(0.0, 0.03, 1.0, 0.97))  # below: the caption
    figure = Figure(figsize=(11.0, 6.5), dpi=120, layout=layout)
    strips, axes = figure.subplots(2, 1, sharex=True, height_ratios=(1, 14))
    figure.suptitle(title_of(echogram, view.echogram_beam), fontsize=12)
    _draw_strips(strips, layers, view.echogram_layers)
    levels = pooled(echogram.level_db, COLUMNS, CELLS)
    extent = (0.0, len(echogram.level_db) * echogram.per_column, echogram.level_db.shape[1] * echogram.cell_m, 0.0)
    picture = axes.imshow(
        levels.T, extent=extent, aspect="auto", vmin=view.lowest_db, vmax=view.highest_db, interpolation="nearest",
        cmap=view.palette,
    )  # fmt: skip
    axes.set(xlabel="ping", ylabel="range, m", xlim=extent[:2], ylim=extent[2:])
    style_colour_bar(figure.colorbar(picture, ax=axes, pad=0.01), "level over the median, dB")
    _draw_layers(axes, layers, view.echogram_layers)
    handles, names = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, names, loc="outside lower center", ncols=len(handles))
    return figure


def _draw_strips(axes: Axes, layers: Layers, shown: Sequence[str]) -> None:
    rows = [("list", layers.invalid, BAD)] * ("validity" in shown) + [("image", layers.faults, OTHER)] * (
        "faults" in shown
    )
    for row, (_, spans, colour) in enumerate(rows):
        axes.broken_barh([_bar(span) for span in spans], (row - 0.4, 0.8), color=colour)
    axes.set_yticks(range(len(rows)), [name for name, *_ in rows])
    axes.set_ylim(-0.5, max(len(rows), 1) - 0.5)
    axes.tick_params(bottom=False, labelbottom=False)
    axes.set_visible(bool(rows))


def _bar(span: Span) -> tuple[float, float]:
    """Return begin and length; of what is missing between two pings a line."""
    return float(span.first), max(0.3, float(span.stop - span.first))


def _draw_layers(axes: Axes, layers: Layers, shown: Sequence[str]) -> None:
    if "echoes" in shown and layers.echoes.place:
        at = np.array(layers.echoes.place) + 0.5
        axes.plot(at, layers.echoes.range_m, ".", color=BAD, markersize=2.0, label="detection")
    ways = [*(layers.truths if "truth" in shown else ()), *(layers.tracks if "tracks" in shown else ())]
    named: set[tuple[bool, str]] = set()
    roles: set[str] = set()
    for way in ways:
        _draw_way(axes, way, label="" if way.role in roles else way.role.replace("_", "-"))
        roles.add(way.role)
        key = way.role == TRUTH, way.label
        if key not in named:
            named.add(key)
            _name(axes, way)


def _draw_way(axes: Axes, way: Way, label: str) -> None:
    ranges = np.array([np.nan if far_m is None else far_m for far_m in way.range_m])
    line = "--" if way.role == TRUTH else "-"
    axes.plot(np.array(way.place) + 0.5, ranges, line, color=COLOURS[way.role], linewidth=1.4, label=label or None)


def _name(axes: Axes, way: Way) -> None:
    """Write a true object's name at its end, a track's at its begin."""
    place, far_m = [pair for pair in zip(way.place, way.range_m, strict=True) if pair[1] is not None][
        -1 if way.role == TRUTH else 0
    ]
    axes.annotate(
        way.label, (place + 0.5, float(far_m or 0.0)), (0, 6), textcoords="offset points", fontsize=9,
        ha="right" if way.role == TRUTH else "left", color=COLOURS[way.role], path_effects=outline(),
    )  # fmt: skip
