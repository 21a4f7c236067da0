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
        help="check the default chain on labelled frames, too; may be given again",
    )  # fmt: skip
    parser.add_argument(
        "--scene", type=Path, action="append", default=[], metavar="SCENE.toml",
        help="with --own: images of a scene, or of all in a folder; may be given again",
    )  # fmt: skip
    parser.add_argument("--sonar", default="seabat6012", metavar="NAME", help="that --scene is seen by, or a path")
    parser.add_argument("--own", action="store_true", help="judge all settings on --real and --scene, and nothing else")
    parser.add_argument(
        "--without", action="append", default=[], metavar="WORD",
        help="leave settings out whose name has it, such as OS-CFAR, which take the longest; may be given again",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="a few images and settings, to see that it works")


def run(args: Namespace) -> None:
    """Measure, print and draw. Raises OdsError."""
    if (args.scene or args.config) and not args.own:
        raise OdsError("--scene, --config: only with --own")
    refuse_missing(args.config, *args.scene, *(file for pair in args.real for file in pair))
    refuse_unwritable(args.out, read=(args.config,))
    from ods.assess.detection.assessment import run as work  # takes seconds: after what may be wrong

    work(args)
