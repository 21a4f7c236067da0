"""`ods assess sea`: share of the lists that objects are in, false obstacles and times, over many sea-beds."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.assess.scene_files import SEA_BEDS
from ods.base.command_line.arguments import duration_s, number, positive_int
from ods.base.errors import OdsError
from ods.base.files.in_file import refuse_missing
from ods.base.files.out_file import refuse_unwritable
from ods.plots.style import add_style

SECONDS = 35.0
CLEARANCE_M = 1.0


def add_arguments(parser: ArgumentParser) -> None:
    """Scenes, effort and chart."""
    parser.add_argument("--out", type=Path, metavar="CHART.png", help="draw the chart")
    add_style(parser)
    parser.add_argument("--scenes", nargs="+", metavar="NAME", help=f"scenes of config/{SEA_BEDS} (default: all)")
    parser.add_argument(
        "--scene", type=Path, action="append", default=[], metavar="SCENE.toml",
        help="another scene, or all in a folder, instead; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--kinds", nargs="*", metavar="KIND", help="of scenes beyond sea-beds, instead: other sonars, hovering, other "
        "sonars' sound, second ways, many objects, noisy poses (default: all of them)",
    )  # fmt: skip
    parser.add_argument("--sonar", default="seabat6012", metavar="NAME", help="that sees them, or a path")
    parser.add_argument("--seconds", type=duration_s, default=SECONDS, help=f"of each scene (default: {SECONDS:g})")
    parser.add_argument("--seeds", type=positive_int, default=1, metavar="N", help="runs of each scene, each with "
                        "another sea-bed and other speckle (default: 1)")  # fmt: skip
    clearance = number(0.0, 1000.0, "metres")
    parser.add_argument("--clearance", type=clearance, default=CLEARANCE_M, metavar="M", help="what is lower over the "
                        f"sea-bed need not be tracked (default: {CLEARANCE_M:g})")  # fmt: skip
    parser.add_argument("--no-altitude", action="store_true", help="omit the altitude from the vehicle's pose")
    parser.add_argument("--images", type=Path, metavar="FOLDER", help="folder in which images are stored and reused")
    parser.add_argument("--jobs", type=positive_int, default=1, metavar="N", help="scenes at a time (default: 1)")


def run(args: Namespace) -> None:
    """Run the scenes, print the tables, draw the chart. Raises OdsError."""
    if args.kinds is not None and (args.scenes or args.scene or args.out):
        raise OdsError("--kinds: cannot be combined with --scenes, --scene or --out")
    refuse_missing(args.config, *args.scene)
    refuse_unwritable(args.out, read=(args.config,))
    from ods.assess.sea.assessment import run as work  # takes seconds: after what may be wrong

    work(args)
