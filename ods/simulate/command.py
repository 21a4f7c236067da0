"""`ods simulate`: a scene file to recorded pings or pictures, by the same code as the live simulator."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import positive_int
from ods.base.errors import OdsError
from ods.base.files.in_file import refuse_missing
from ods.base.files.out_file import refuse_unwritable
from ods.plots.style import add_style


def add_arguments(parser: ArgumentParser) -> None:
    """A scene to a file, or figures of the simulator itself."""
    parser.add_argument("scene", type=Path, metavar="SCENE.toml", nargs="?", help="the scene, as in config/scenes")
    parser.add_argument("--sonar", default="seabat6012", metavar="NAME", help="file in config/sonars, or a path")
    parser.add_argument("--out", type=Path, metavar="FILE", help=".npz pings, .s7k, or .png fan images")
    parser.add_argument("--pings", type=positive_int, metavar="N", help="default: the whole scene; for .png one")
    parser.add_argument("--seed", type=int, metavar="N", help="instead of the scene's own")
    parser.add_argument("--chart", type=Path, metavar="OUT.png", help="draw error against time at all resolutions")
    add_style(parser)
    parser.add_argument("--table", action="store_true", help="print the time for each part of an image")


def run(args: Namespace) -> None:
    """Write, print and draw the requested results. Raises OdsError."""
    if not args.chart and not args.table and not (args.scene and args.out):
        raise OdsError("give SCENE.toml and --out, or --chart, or --table")
    refuse_missing(args.scene)
    refuse_unwritable(args.chart)
    from ods.simulate.simulation import run as work  # takes seconds: after what may be wrong

    work(args)
