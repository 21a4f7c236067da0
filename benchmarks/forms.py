"""Draws where each form of a filter's covariance update breaks, and prints what each costs.

Run: python -m benchmarks.forms [--quick] --out PICTURE.png
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from benchmarks.covariance_forms import FORMS, FULL, QUICK, TIMED_FILTERS, TYPES, Grid, measure
from ods.base.errors import OdsError
from ods.plots.chart import dress, save_figure
from ods.plots.fan import dress_bar
from ods.plots.style import MARK, add_style, drawn_in

LEAST, MOST = -17.0, 0.0
"""Borders of the colours, powers of ten."""


def draw(grid: Grid) -> Figure:
    """Return one panel for each precision and form: colour is the error, a cross lost positive definiteness."""
    figure = Figure(figsize=(14.0, 7.5), dpi=110, layout="constrained")
    axes = figure.subplots(len(TYPES), len(FORMS), sharex=True, sharey=True, squeeze=False)
    x, y = np.log10(grid.effort.ratios), np.log10(grid.effort.intervals)
    for row, precision in enumerate(TYPES):
        for column, name in enumerate(FORMS):
            panel, place = grid.panels[precision, name], axes[row, column]
            level = np.log10(np.clip(panel.error, 10.0**LEAST, 10.0**MOST))
            mesh = place.pcolormesh(x, y, level, shading="nearest", norm=Normalize(LEAST, MOST))
            lines, rows = np.nonzero(panel.broken)
            place.plot(x[rows], y[lines], "x", color=MARK, ms=4, mew=1.0)
            dress(place, f"{name}, {precision}", "", "")
            place.grid(visible=False)
    for place in axes[-1]:
        place.set_xlabel("log10 of noise ratio")
    for place in axes[:, 0]:
        place.set_ylabel("log10 of interval, s")
    dress_bar(figure.colorbar(mesh, ax=axes), "log10 of worst relative error of the covariance")
    updates = grid.effort.updates * len(x) * len(y)
    figure.suptitle(f"Covariance updates, {updates:,} a panel; cross: not positive definite")
    return figure


def table(grid: Grid) -> Table:
    """Return one line for each precision and form."""
    result = Table(title=f"{grid.effort.updates} updates of each filter; time of {TIMED_FILTERS} filters, both updates")
    for heading in ("precision", "form", "us", "broken", "worst error", "worst asymmetry"):
        result.add_column(heading, justify="left" if heading in ("precision", "form") else "right")
    for (precision, name), panel in grid.panels.items():
        result.add_row(
            precision,
            name,
            f"{panel.microseconds:.1f}",
            f"{panel.broken.mean():.0%}",
            f"{panel.error.max():.0e}",
            f"{panel.asymmetry.max():.0e}",
        )
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print the table and draw the picture; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, metavar="PICTURE.png")
    parser.add_argument("--quick", action="store_true", help="a small grid, to see that it works")
    add_style(parser)
    args = parser.parse_args(arguments)
    grid = measure(QUICK if args.quick else FULL)
    Console(width=120).print(table(grid))
    try:
        with drawn_in(args.style):
            save_figure(draw(grid), args.out)
    except OdsError as error:
        print(error, file=sys.stderr)
        return 2
    print(f"drawn: {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
