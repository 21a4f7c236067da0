"""`ods veto region`: a planner may ignore static obstacles in a region for some time."""

from argparse import ArgumentParser, Namespace

import msgspec

from ods.base.command_line.arguments import number
from ods.base.errors import OdsError
from ods.client import VetoRegion, VetoRequest
from ods.commands.veto.asking import add_reason, add_time, ask
from ods.messages import LARGEST_REGION_M

METRES = number(-1e7, 1e7, "metres")


def add_arguments(parser: ArgumentParser) -> None:
    """Where, why, and how long."""
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument(
        "--circle", nargs=3, type=METRES, metavar=("NORTH", "EAST", "RADIUS"), help="position in the local frame, m"
    )
    where.add_argument(
        "--polygon", nargs="+", type=METRES, metavar="NORTH EAST", help="its corners in order, at least three"
    )
    parser.add_argument(
        "--down",
        nargs=2,
        type=METRES,
        metavar=("FROM", "TO"),
        help="limits of the depth, m; for sonars of several planes",
    )
    add_reason(parser)
    add_time(parser)


def run(args: Namespace) -> None:
    """Ask for it. Raises OdsError."""
    ask(args, VetoRequest(do="ignore", region=_region(args), reason=args.reason, for_s=args.for_s))


def _region(args: Namespace) -> VetoRegion:
    """Raises OdsError."""
    corners: list[float] = args.polygon or []
    if len(corners) % 2:
        raise OdsError("--polygon: a north without its east")
    centre, radius_m = None, 0.0
    if args.circle is not None:
        centre, radius_m = (args.circle[0], args.circle[1]), args.circle[2]
        if not 0.0 < radius_m <= LARGEST_REGION_M:
            raise OdsError(f"--circle: the radius must be above 0 and at most {LARGEST_REGION_M:g} m")
    wanted = {
        "centre_ne": centre,
        "radius_m": radius_m,
        "corners_ne": list(zip(corners[::2], corners[1::2], strict=True)),
        "down_m": args.down,
    }
    try:
        return msgspec.convert(wanted, VetoRegion)
    except msgspec.ValidationError as error:
        raise OdsError(f"region: {error}") from None
