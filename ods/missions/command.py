"""`ods missions`: many missions in random worlds, with the vehicle in the loop, and what came of them."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import positive_int
from ods.base.errors import OdsError
from ods.base.files.in_file import refuse_missing
from ods.base.files.out_file import refuse_unwritable
from ods.plots.style import add_style


def add_arguments(parser: ArgumentParser) -> None:
    """A campaign and where its results go."""
    parser.add_argument("campaign", type=Path, metavar="CAMPAIGN.toml", help="worlds, arms, vehicle, planner")
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--out", type=Path, metavar="DIR",
                      help="run it; folder for the results; a stopped campaign continues there")  # fmt: skip
    what.add_argument("--fit", type=Path, metavar="FILE.json",
                      help="run some missions with images, and fit distributions of detections to them")  # fmt: skip
    parser.add_argument("--chart", action="store_true",
                        help="with --out: chart of collisions against time per ping, by variant")  # fmt: skip
    add_style(parser)
    who = parser.add_mutually_exclusive_group()
    who.add_argument("--workers", type=positive_int, default=1, metavar="N", help="processes (default: 1)")
    who.add_argument(
        "--cluster", metavar="ADDRESS", help="use the workers of this Dask scheduler instead: tls://HOST:PORT"
    )
    parser.add_argument("--tls", type=Path, metavar="FOLDER", help="for --cluster: ca.pem, cert.pem and key.pem")


def run(args: Namespace) -> None:
    """Fly all missions that are not done yet and print the results of all. Raises OdsError."""
    refuse_missing(args.campaign)
    if args.chart and args.out is None:
        raise OdsError("--chart: needs --out, the folder for it")
    if args.tls is not None and args.cluster is None:
        raise OdsError("--tls: goes with --cluster")
    if args.fit is not None:
        refuse_unwritable(args.fit, read=[args.campaign])
    from ods.missions.run import run as work  # takes seconds: after what may be wrong

    work(args)
