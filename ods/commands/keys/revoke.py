"""`ods keys revoke`: a client may listen no longer."""

from argparse import ArgumentParser, Namespace

from ods.commands.keys.folder import folder_of


def add_arguments(parser: ArgumentParser) -> None:
    """Whose key."""
    parser.add_argument("name", metavar="NAME", help="of the client, as `ods keys list` has it")


def run(args: Namespace) -> None:
    """Take it from the list. Raises OdsError."""
    folder_of(args.config).revoke(args.name)
    print(f"{args.name} may listen no longer: where it does, `ods listen` hangs up at once")
