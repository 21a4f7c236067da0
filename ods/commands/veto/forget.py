"""`ods veto forget`: an obstacle is dropped, from the map, too."""

from argparse import ArgumentParser, Namespace

from ods.base.command_line.arguments import positive_int
from ods.client import VetoRequest
from ods.commands.veto.asking import add_reason, ask


def add_arguments(parser: ArgumentParser) -> None:
    """Which, and why."""
    parser.add_argument("id", type=positive_int, metavar="ID", help="of the obstacle")
    add_reason(parser)


def run(args: Namespace) -> None:
    """Ask for it. Raises OdsError."""
    ask(args, VetoRequest(do="forget", id=args.id, reason=args.reason))
