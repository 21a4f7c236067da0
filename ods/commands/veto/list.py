"""`ods veto list`: the vetoes that hold."""

from argparse import ArgumentParser, Namespace

from ods.client import VetoRequest
from ods.commands.veto.asking import add_key, ask


def add_arguments(parser: ArgumentParser) -> None:
    """Whose key."""
    add_key(parser)


def run(args: Namespace) -> None:
    """Ask for it. Raises OdsError."""
    ask(args, VetoRequest(do="list"))
