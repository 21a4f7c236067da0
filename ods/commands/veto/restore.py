"""`ods veto restore`: a veto ends before it expires."""

from argparse import ArgumentParser, Namespace

from ods.base.command_line.arguments import positive_int
from ods.client import VetoRequest
from ods.commands.veto.asking import add_reason, ask


def add_arguments(parser: ArgumentParser) -> None:
    """Which, and why."""
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("id", nargs="?", type=positive_int, metavar="ID", help="of the obstacle")
    which.add_argument("--veto", type=int, metavar="NUMBER", help="of the veto, as in `ods veto list`")
    add_reason(parser)


def run(args: Namespace) -> None:
    """Ask for it. Raises OdsError."""
    ask(args, VetoRequest(do="restore", id=args.id, number=args.veto, reason=args.reason))
