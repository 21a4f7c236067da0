"""`ods keys revoke`: a client may listen no longer, or an operator veto."""

from argparse import ArgumentParser, Namespace

from ods.commands.keys.folder import folder_of
from ods.runtime.keys.key_folder import CLIENTS, OPERATORS


def add_arguments(parser: ArgumentParser) -> None:
    """Whose key."""
    parser.add_argument("name", metavar="NAME", help="of the client, as in `ods keys list`")
    parser.add_argument("--operator", action="store_true", help="of an operator")


def run(args: Namespace) -> None:
    """Take it from the list. Raises OdsError."""
    folder_of(args.config, OPERATORS if args.operator else CLIENTS).revoke(args.name)
    if args.operator:
        print(f"{args.name} may no longer veto; its vetoes remain until they expire (`ods veto list`)")
    else:
        print(f"{args.name} may no longer listen; `ods listen` closes its connections at once")
