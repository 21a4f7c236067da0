"""`ods track`: pipeline and tracker as on board, on recorded or simulated pings; the tracker alone on scenarios."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import choice
from ods.base.files.in_file import refuse_missing
from ods.plots.style import add_style


def add_arguments(parser: ArgumentParser) -> None:
    """Pings with poses, and what is made of them."""
    parser.add_argument(
        "file", type=Path, metavar="FILE",
        help="pings with poses: .npz, .s7k, a recording of ods record; a scene, .toml; a scenario of detections, .npz",
    )  # fmt: skip
    parser.add_argument("--fan", type=Path, metavar="FAN.toml", help="geometry of the fan images of an .avi clip")
    parser.add_argument(
        "--sonar", default="seabat6012", metavar="NAME", help="sonar of the scene: a name, or the path of its file"
    )
    parser.add_argument("--pings", type=choice, metavar="WHICH", help="only these, counted from 0: 10:20, ::5, :100")
    parser.add_argument("--out", type=Path, metavar="TRACKS.npz", help="write the tracks as .npz")
    parser.add_argument("--json", action="store_true", help="print one JSON line per ping: its obstacle list")
    parser.add_argument("--geojson", type=Path, metavar="FILE", help="write paths and objects as geographic data")
    parser.add_argument("--plot", type=Path, metavar="PICTURE.png", help="draw the last image and a plan view")
    parser.add_argument("--movie", type=Path, metavar="MOVIE.webp", help="the same as a movie; .webp or .gif")
    add_style(parser)


def run(args: Namespace) -> None:
    """Track a file or a scene; without a configuration with default settings. Raises OdsError."""
    refuse_missing(args.file, args.config, args.fan)
    from ods.track.run import run as work  # takes seconds: after what may be wrong

    work(args)
