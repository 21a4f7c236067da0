"""`ods assess detect`: accuracy against time of every filter x detector x attention, on simulated and real images."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.files.in_file import refuse_missing
from ods.base.files.out_file import refuse_unwritable
from ods.plots.style import add_style


def add_arguments(parser: ArgumentParser) -> None:
    """Chart, real frames and effort."""
    parser.add_argument("--out", type=Path, metavar="CHART.png", help="draw the chart")
    add_style(parser)
    parser.add_argument(
        "--real", type=Path, nargs=2, action="append", default=[], metavar=("RECORDING", "LABELS"),
        help="also check the default chain on labelled frames; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--scene", type=Path, action="append", default=[], metavar="SCENE.toml",
        help="with --own: images of a scene, or of all scenes in a folder; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--sonar", default="seabat6012", metavar="NAME", help="sonar for --scene: a name, or the path of its file"
    )
    parser.add_argument("--own", action="store_true", help="only rank all settings on --real and --scene")
    parser.add_argument(
        "--without", action="append", default=[], metavar="WORD",
        help="omit settings with this text in their name, such as OS-CFAR, the slowest; repeatable",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="a quick check with a few images and settings")


def run(args: Namespace) -> None:
    """Measure, print and draw. Raises OdsError."""
    if (args.scene or args.config) and not args.own:
        raise OdsError("--scene, --config: only with --own")
    refuse_missing(args.config, *args.scene, *(file for pair in args.real for file in pair))
    refuse_unwritable(args.out, read=(args.config,))
    from ods.assess.detection.assessment import run as work  # takes seconds: after what may be wrong

    work(args)
