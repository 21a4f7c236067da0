"""`ods detect`: the pipeline as on board, on recorded sonar images."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import choice
from ods.base.errors import OdsError
from ods.base.files.in_file import refuse_missing
from ods.plots.style import add_style


def add_arguments(parser: ArgumentParser) -> None:
    """Recording, which pings of it, and what is made of them."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help=".npz, .s7k, .aris, .raw, .oculus, .wbms, .sonar, .avi, or a recording of ods record",
    )
    parser.add_argument("--fan", type=Path, metavar="FAN.toml", help="geometry of the fan images of an .avi clip")
    parser.add_argument(
        "--pings", type=choice, metavar="WHICH", help="only these, counted from 0: 10:20, ::5, 7, or 0,3,20:30"
    )
    parser.add_argument("--out", type=Path, metavar="DET.npz", help="write the detections as .npz")
    parser.add_argument("--mask", action="store_true", help="with --out: label images too")
    said = parser.add_mutually_exclusive_group()
    said.add_argument("--json", action="store_true", help="print one JSON line per ping")
    said.add_argument("--quiet", action="store_true", help="print no line per ping")
    parser.add_argument("--plot", type=Path, metavar="PICTURE.png", help="draw the images with their detections")
    parser.add_argument("--sheet", type=Path, metavar="SHEET.png", help="the same, with all pings on one picture")
    parser.add_argument(
        "--plot-stages", type=Path, metavar="PICTURE.png", help="draw the output of each stage, with the levels"
    )
    add_style(parser)


def run(args: Namespace) -> None:
    """Run the pipeline over a recording; without a configuration with its default chain. Raises OdsError."""
    if args.mask and args.out is None:
        raise OdsError("--mask: needs --out, the file that it is written to")
    refuse_missing(args.file, args.config, args.fan)
    from ods.commands.detect_recording import run as work  # takes a while: after what may be wrong

    work(args)
