"""`ods assess track`: the table and charts of all observers, the paper's figures 6 and 7, scenario files."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import positive_int
from ods.base.files.in_file import refuse_missing
from ods.base.files.out_file import refuse_unwritable
from ods.plots.style import add_style


def add_arguments(parser: ArgumentParser) -> None:
    """The assessment, or one of the other figures and files instead."""
    parser.add_argument("--out", type=Path, metavar="CHART.png", help="draw the chart")
    add_style(parser)
    parser.add_argument("--seeds", type=positive_int, metavar="N", help="runs of each scenario (default: 5)")
    parser.add_argument("--first-seed", type=int, default=0, metavar="N", help="seed of the first run (default: 0)")
    parser.add_argument("--scenarios", nargs="+", default=[], metavar="NAME", help="only these")
    parser.add_argument(
        "--trackers", nargs="+", default=[], metavar='"OBSERVER, ASSOCIATION"',
        help="only these combinations of observer and association",
    )  # fmt: skip
    parser.add_argument(
        "--peers", action="store_true", help="also run the trackers of the library Stone Soup; takes minutes"
    )
    parser.add_argument(
        "--scene", type=Path, action="append", default=[], metavar="SCENE.toml",
        help="objects and vehicle of this scene, or of all scenes in a folder, instead of the scenarios; repeatable",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="a quick check with a few scenarios")
    parser.add_argument("--figures", type=Path, metavar="OUT.png", help="draw figures 6 and 7 of [SSIE] instead")
    parser.add_argument("--save", type=Path, metavar="FOLDER", help="write the scenarios for `ods track` instead")


def run(args: Namespace) -> None:
    """Run the command. Raises OdsError."""
    refuse_missing(args.config, *args.scene)
    refuse_unwritable(args.out, args.figures, read=(args.config,))
    from ods.assess.track.assessment import run as work  # takes seconds: after what may be wrong

    work(args)
