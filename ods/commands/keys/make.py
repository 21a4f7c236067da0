"""`ods keys make`: a client may listen, or an operator may veto obstacles."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.errors import reason_of
from ods.base.files.in_file import text_of
from ods.commands.keys.folder import folder_of
from ods.runtime.keys.key_files import KeyFileError
from ods.runtime.keys.key_folder import CLIENTS, OPERATORS


def add_arguments(parser: ArgumentParser) -> None:
    """Whose key."""
    parser.add_argument("name", metavar="NAME", help="of the client: letters, digits and ._-")
    parser.add_argument(
        "--operator", action="store_true", help="make an operator's key, which may veto obstacles (`ods veto`)"
    )
    parser.add_argument(
        "--public", type=Path, metavar="FILE", help="file with the client's public key, if it has made its own pair"
    )


def run(args: Namespace) -> None:
    """Make a pair, or take a public key; allow it. Raises OdsError."""
    folder = folder_of(args.config, OPERATORS if args.operator else CLIENTS)
    may = "veto" if args.operator else "listen"
    if args.public is not None:
        folder.allow(args.name, _key_in(args.public))
        print(f"{args.name} may {may}; the public key of this vehicle: {folder.server().public}")
        return
    secret = folder.make(args.name)
    print(f"{args.name} may {may} with {secret}: move this file to the computer that uses it, and keep no copy")


def _key_in(path: Path) -> str:
    """Return what a file holds: as an argument, a key may begin with -, or be the shell's. Raises KeyFileError."""
    try:
        return text_of(path).strip()
    except (OSError, UnicodeDecodeError) as error:
        raise KeyFileError(f"{path}: {reason_of(error)}") from error
