"""The styles of all pictures: dark for screens, light for print.

Inside `drawn_in` whatever is drawn and saved has the style's colours; series are the names "C0" to "C7", which
Matplotlib looks up while it draws.
"""

from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from ods.base.errors import OdsError


class Palette(NamedTuple):
    """The colours of a style."""

    paper: str
    ink: str
    """Text, ticks and axes."""
    series: tuple[str, ...]
    """Eight that can be distinguished, by `MARK` to `STRONG`."""
    images: str
    """Colour map."""


DARK = "dark"
PALETTES = {
    DARK: Palette(
        paper="#0d1117",
        ink="#c9d1d9",
        series=("#39d0ff", "#ffa657", "#7ee787", "#d2a8ff", "#ff7b72", "#8b949e", "#f2cc60", "#ffffff"),
        images="inferno",
    ),
    "light": Palette(
        paper="#ffffff",
        ink="#1f2328",
        series=("#0969da", "#d4610c", "#1a7f37", "#8250df", "#cf222e", "#818b98", "#9a6700", "#000000"),
        images="Greys",
    ),
}
SERIES = tuple(f"C{index}" for index in range(8))
MARK, ACCENT, GOOD, OTHER, BAD, QUIET, WARN, STRONG = SERIES
"""What the series are called where each has a meaning of its own."""


def add_style(parser: ArgumentParser) -> None:
    """`--style`, which all commands take that draw."""
    parser.add_argument("--style", choices=tuple(PALETTES), default=DARK, help="of pictures; light: for print")


def refuse_undrawable(*pictures: Path | None) -> None:
    """Raise OdsError, one line, for the first whose ending is not that of a format that can be drawn; None is not
    wanted."""
    for picture in filter(None, pictures):
        from matplotlib.backend_bases import FigureCanvasBase  # an extra, which only pictures need

        endings = FigureCanvasBase.get_supported_filetypes()
        if picture.suffix and picture.suffix[1:].lower() not in endings:
            raise OdsError(f"{picture}: the ending must be one of {', '.join(f'.{name}' for name in sorted(endings))}")


@contextmanager
def drawn_in(style: str) -> Iterator[None]:
    """Draw in a style of PALETTES; pictures have to be saved inside, too, as some colours are looked up then."""
    import matplotlib  # an extra, which commands need only when they draw
    from cycler import cycler

    paper, ink, series, images = PALETTES[style]
    colours: Any = {
        **dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor", "legend.facecolor"), paper),
        **dict.fromkeys(("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"), ink),
        **dict.fromkeys((f"axes.spines.{side}" for side in ("left", "right", "top", "bottom")), False),
        **{"grid.color": ink, "grid.alpha": 0.15, "image.cmap": images, "axes.prop_cycle": cycler(color=series)},
        **{"legend.edgecolor": "none", "legend.framealpha": 0.85, "legend.fontsize": 9},
    }
    with matplotlib.rc_context(colours):
        yield


def outline() -> list[Any]:
    """Return the path effect, in the paper's colour, that keeps marks and texts readable on whatever is below."""
    from matplotlib import rcParams
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=3.0, foreground=rcParams["figure.facecolor"])]
