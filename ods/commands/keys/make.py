"""`ods keys make`: a client may listen."""

from argparse import ArgumentParser, Namespace

from ods.commands.keys.folder import folder_of


def add_arguments(parser: ArgumentParser) -> None:
    """Whose key."""
    parser.add_argument("name", metavar="NAME", help="of the client: letters, digits and ._-")
    parser.add_argument("--public", metavar="KEY", help="its public key, where it made its pair itself")


def run(args: Namespace) -> None:
    """Make a pair, or take a public key; allow it. Raises OdsError."""
    folder = folder_of(args.config)
    if args.public is not None:
        folder.allow(args.name, args.public)
        print(f"{args.name} may listen; the public key of this vehicle: {folder.server().public}")
        return
    secret = folder.make(args.name)
    print(f"{args.name} may listen with {secret}: move it to the client's computer, and leave no copy")
