"""`ods veto ignore`: a planner may ignore an obstacle for a time."""

from argparse import ArgumentParser, Namespace

from ods.base.command_line.arguments import positive_int
from ods.client import VetoRequest
from ods.commands.veto.asking import add_reason, add_time, ask


def add_arguments(parser: ArgumentParser) -> None:
    """Which, why, and how long."""
    parser.add_argument("id", type=positive_int, metavar="ID", help="of the obstacle")
    add_reason(parser)
    add_time(parser)


def run(args: Namespace) -> None:
    """Ask for it. Raises OdsError."""
    ask(args, VetoRequest(do="ignore", id=args.id, reason=args.reason, for_s=args.for_s))
